// A way to step a system in time; one file a method.
#pragma once

#include <limits>

#include "scene/system.hpp"

namespace serpenoid {

struct StepOutcome {
    bool ok = true;
    const char* why = "";  // short cause, for the error message
};

class Method {
  public:
    virtual ~Method() = default;

    // Begin at t, and again behind every jump of the system.
    virtual void restart(double t, const double* y) = 0;

    // One step, never beyond the limit.
    virtual StepOutcome step(double t_limit) = 0;
    virtual double time() const = 0;
    virtual const double* state() const = 0;

    // The state at a time within the last step, and its order. A method without dense output (0) is
    // asked for the ends of its steps only: it is never stepped over a time that is recorded.
    virtual int dense_order() const { return 0; }
    virtual void dense(double t, double* y) const = 0;

    // Put into the chain and the joints, at the present state, the forces that the method finds and
    // the system does not know: friction that is set-valued. The chain is filled, and has its
    // rates.
    virtual void give_forces(System&) {}

    // Estimated error of the last step, in the scale of its tolerance; NaN: not known.
    virtual double local_error() const { return std::numeric_limits<double>::quiet_NaN(); }
};

}  // namespace serpenoid
