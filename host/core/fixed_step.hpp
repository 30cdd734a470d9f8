// What methods with a fixed step share: the time, kept as a whole number of steps.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "method.hpp"
#include "system.hpp"

namespace serpenoid {

class FixedStep : public Method {
  public:
    FixedStep(System& system, double dt) : system_(system), dt_(dt), y_(system.dim()) {}

    void restart(double t, const double* y) override {
        origin_ = t_ = t, steps_ = 0;
        std::copy_n(y, y_.size(), y_.begin());
    }
    StepOutcome step(double t_limit) override {
        double to = origin_ + static_cast<double>(steps_ + 1) * dt_;
        // a limit within rounding of the step's end is its end
        const bool limited = to > t_limit - 1e-9 * dt_;
        if (limited) to = t_limit;
        advance(t_, to - t_, y_.data());
        t_ = to, ++steps_;
        if (limited) origin_ = to, steps_ = 0;  // or the next step would be longer than dt
        return {};
    }
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    void dense(double, double* y) const override { std::copy(y_.begin(), y_.end(), y); }

  protected:
    virtual void advance(double t, double dt, double* y) = 0;
    System& system_;
    double dt_;

  private:
    double t_ = 0, origin_ = 0;
    long steps_ = 0;
    std::vector<double> y_;
};

}  // namespace serpenoid
