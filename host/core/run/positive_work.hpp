// The positive work of a run's joints, from the dense output of its method.
#pragma once

#include <array>
#include <vector>

#include "methods/method.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// P_i^+ has a kink where a joint's power P_i changes its sign. A method that integrates it beside
// the motion loses its order there, and shortens its steps. P_i itself is smooth within a step:
// parabolas through its values on four panels are integrated between their roots.
class PositiveWork {
  public:
    // For a method with dense output. The system's ledger leaves the positive work to this.
    PositiveWork(System& system, const Method& method);

    // The method has taken a step from the end of the last one.
    void step();

    // Work up to a time within the last step, J.
    double until(double t) const;

  private:
    static constexpr int kPanels = 4;

    System& system_;
    const Method& method_;
    double start_ = 0;  // of the last step, s
    double end_ = 0;
    double done_ = 0;  // work before it, J
    std::vector<double> y_;
    std::vector<double> power_;
    std::vector<std::array<double, 2 * kPanels + 1>> samples_;  // of every joint's power, W
};

}  // namespace serpenoid
