// What methods with a fixed step share: the time, kept as a whole number of steps.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "methods/method.hpp"
#include "scene/system.hpp"

namespace serpenoid {

class FixedStep : public Method {
  public:
    FixedStep(System& system, double dt) : system_(system), dt_(dt), y_(system.dim()) {}

    void restart(double t, const double* y) override {
        origin_ = t;
        t_ = t;
        steps_ = 0;
        std::copy_n(y, y_.size(), y_.begin());
    }
    const char* step(double t_limit) override {
        const double step_end = origin_ + static_cast<double>(steps_ + 1) * dt_;
        // a limit within rounding of the step's end is its end
        const double rounding = 1e-9 * dt_,
                     target = step_end > t_limit - rounding ? t_limit : step_end;
        advance(t_, target - t_, y_.data());
        t_ = target;
        ++steps_;
        // count anew behind a shortened step, or the next would be longer than dt; behind a whole
        // one go on, or what is recorded would change the times of the steps
        if (step_end > t_limit + rounding) {
            origin_ = target;
            steps_ = 0;
        }
        return nullptr;
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
    long long steps_ = 0;
    std::vector<double> y_;
};

}  // namespace serpenoid
