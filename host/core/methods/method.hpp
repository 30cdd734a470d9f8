// Interface of the time integration methods; each method has its own file.
#pragma once

#include <limits>

#include "scene/system.hpp"

namespace serpenoid {

class Method {
  public:
    virtual ~Method() = default;

    // Start from the state y at time t; called at the beginning and after every jump of the system.
    virtual void restart(double t, const double* y) = 0;

    // Take one step that ends at the limit or before it; null, or the short cause of its failure.
    virtual const char* step(double t_limit) = 0;
    virtual double time() const = 0;
    virtual const double* state() const = 0;

    // Dense output: the state at a time t within the last step, and the order of its error. A
    // method of order 0 has no dense output: its steps end at every output time, and t is always
    // such an end.
    virtual int dense_order() const { return 0; }
    virtual void dense(double t, double* y) const = 0;

    // Add set-valued friction to the forces of the chain at the present state, if the method and
    // not the system computes it. Requires a chain with velocities and accelerations.
    virtual void add_friction(System&) {}

    // Estimated error of the last step, in the unit of the tolerance; NaN if the method has none.
    virtual double local_error() const { return std::numeric_limits<double>::quiet_NaN(); }
};

}  // namespace serpenoid
