// Nonsmooth steps of the implicit model: exact sticking by a closed formula, wheel by wheel.
//
// Springs and dampers act over a whole step, then friction: each link is a body of its own, so its
// convex problem  min m/2 |v - v*|^2 + h(c_t v_t^2/2 + F_t0 |v_t| + ...)  falls into two scalar
// ones, solved by shrinking:  v = max(|v*| - h F0/m, 0) sgn v* / (1 + h c/m).  First order.
#pragma once

#include <cmath>
#include <vector>

#include "fixed_step.hpp"
#include "params.hpp"

namespace serpenoid {

inline double shrink(double v, double dry, double viscous) {
    const double left = std::fabs(v) - dry;
    return left > 0 ? std::copysign(left / (1 + viscous), v) : 0.0;
}

// The system is an implicit one without friction; its state starts with the centres.
class ShrinkScheme : public FixedStep {
  public:
    ShrinkScheme(System& frictionless, const Robot& robot, const Ground& ground, double dt)
        : FixedStep(frictionless, dt),
          robot_(robot),
          ground_(ground),
          rate_of_(frictionless.rate_of()),
          dy_(frictionless.dim()) {}

  protected:
    void advance(double t, double dt, double* y) override {
        const int n = robot_.n;
        const double hm = dt / robot_.m;
        system_.rate(t, y, dy_.data());
        for (std::size_t i = 2 * n; i < dy_.size(); ++i)
            if (rate_of_[i] < 0) y[i] += dt * dy_[i];
        for (std::size_t i = 4 * n; i < dy_.size(); ++i)
            if (rate_of_[i] >= 0) y[i] += dt * y[rate_of_[i]];
        system_.fill(t + dt, y);  // the directions of the wheels at the end of the step
        for (int i = 0; i < n; ++i) {
            const double c = system_.chain.c[i], s = system_.chain.s[i];
            double &vx = y[2 * n + i], &vy = y[3 * n + i];
            const double vt = shrink(c * vx + s * vy, hm * ground_.ft0, hm * ground_.ct);
            const double vn = shrink(-s * vx + c * vy, hm * ground_.fn0, hm * ground_.cn);
            vx = c * vt - s * vn, vy = s * vt + c * vn;
            y[i] += dt * vx, y[n + i] += dt * vy;
        }
    }

  private:
    Robot robot_;
    Ground ground_;
    std::vector<int> rate_of_;
    std::vector<double> dy_;
};

}  // namespace serpenoid
