// Semi-implicit (symplectic) Euler with a fixed step, order 1: velocities first, then places with
// the new velocities. Undamped springs neither gain nor lose energy in the mean, up to
// dt = 2/frequency.
#pragma once

#include <vector>

#include "methods/fixed_step.hpp"

namespace serpenoid {

class SemiImplicitEuler : public FixedStep {
  public:
    SemiImplicitEuler(System& system, double dt)
        : FixedStep(system, dt), rate_of_(system.rate_of()), dy_(system.dim()) {}

  protected:
    void advance(double t, double dt, double* y) override {
        system_.rate(t, y, dy_.data());
        for (std::size_t i = 0; i < dy_.size(); ++i)
            if (rate_of_[i] < 0) y[i] += dt * dy_[i];
        for (std::size_t i = 0; i < dy_.size(); ++i)
            if (rate_of_[i] >= 0) y[i] += dt * y[rate_of_[i]];
    }

  private:
    std::vector<int> rate_of_;
    std::vector<double> dy_;
};

}  // namespace serpenoid
