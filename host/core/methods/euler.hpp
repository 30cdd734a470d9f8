// Explicit Euler with a fixed step, order 1: y += dt y'.
#pragma once

#include <vector>

#include "methods/fixed_step.hpp"

namespace serpenoid {

class Euler : public FixedStep {
  public:
    Euler(System& system, double dt) : FixedStep(system, dt), dy_(system.dim()) {}

  protected:
    void advance(double t, double dt, double* y) override {
        system_.rate(t, y, dy_.data());
        for (std::size_t i = 0; i < dy_.size(); ++i) y[i] += dt * dy_[i];
    }

  private:
    std::vector<double> dy_;
};

}  // namespace serpenoid
