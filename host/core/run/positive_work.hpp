// The positive work of a run's joints, from the dense output of its method.
#pragma once

#include <memory>

#include "methods/method.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// P_i^+ has a kink where a joint's power P_i changes its sign. A method that integrates it beside
// the motion loses its order there, and shortens its steps. P_i itself is smooth within a step: the
// polynomial through its values at Gauss's nodes is integrated between its own sign changes.
class PositiveWork {
  public:
    virtual ~PositiveWork() = default;

    // The method has taken a step from the end of the last one.
    virtual void step() = 0;

    // Work up to a time within the last step, J.
    virtual double until(double t) const = 0;
};

// For a method with dense output. The ledger leaves the positive work to it.
std::unique_ptr<PositiveWork> make_positive_work(System& system, const Method& method);

}  // namespace serpenoid
