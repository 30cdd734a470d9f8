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

    // Take one step, which ends at t_limit or before. Return null, or a short cause if it failed.
    virtual const char* step(double t_limit) = 0;
    virtual double time() const = 0;
    virtual const double* state() const = 0;

    // Dense output: dense() gives the state at a time t within the last step, with an error of
    // order dense_order(). If the order is 0, a step ends at every output time, and dense() is
    // called only with t at the end of the last step.
    virtual int dense_order() const { return 0; }
    virtual void dense(double t, double* y) const = 0;

    // Add set-valued friction to the forces of the chain at the present state; does nothing if the
    // system computes the friction. The chain must have its velocities and accelerations.
    virtual void add_friction(System&) {}

    // Estimated error of the last step, in the unit of the tolerance; NaN if the method has none.
    virtual double local_error() const { return std::numeric_limits<double>::quiet_NaN(); }
};

}  // namespace serpenoid
