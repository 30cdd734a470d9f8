// A nonsmooth step of the implicit model: exact sticking by a closed formula, wheel by wheel.
//
// Springs and dampers act over a whole step, then friction: each link is a body of its own, so its
// convex problem  min m/2 |v - v*|^2 + h(c_t v_t^2/2 + F_t0 |v_t| + ...)  falls into two scalar
// ones, solved by shrinking:  v = max(|v*| - h F0/m, 0) sgn v* / (1 + h c/m).  First order.
#pragma once

#include "systems.hpp"

namespace serpenoid {

inline double shrink(double v, double dry, double viscous) {
    const double left = std::fabs(v) - dry;
    return left > 0 ? std::copysign(left / (1 + viscous), v) : 0.0;
}

// The implicit model without friction, stepped semi-implicitly, friction applied by shrink().
struct NoFriction {
    explicit NoFriction(const Ground&, double) {}
    double along(double) const { return 0; }
    double across(double) const { return 0; }
};

class ImplicitProx {
  public:
    explicit ImplicitProx(const RunRequest& request) : system(request), dy_(system.dim()) {}

    void step(double t, double dt, std::vector<double>& y) {
        system.rate(t, y.data(), dy_.data());
        const int n = system.n;
        const Robot& r = system.q.robot;
        const Ground& g = system.q.ground;
        const double hm = dt / r.m;
        y[4 * n + 1] += dt * dy_[4 * n + 1];
        y[4 * n] += dt * y[4 * n + 1];
        system.bend_by_gait(t + dt, y[4 * n], y[4 * n + 1]);
        for (int i = 0; i < n; ++i) {
            const double c = system.chain.c[i], s = system.chain.s[i];
            const double vx = y[2 * n + i] + dt * dy_[2 * n + i];
            const double vy = y[3 * n + i] + dt * dy_[3 * n + i];
            const double vt = shrink(c * vx + s * vy, hm * g.ft0, hm * g.ct);
            const double vn = shrink(-s * vx + c * vy, hm * g.fn0, hm * g.cn);
            y[2 * n + i] = c * vt - s * vn, y[3 * n + i] = s * vt + c * vn;
            y[i] += dt * y[2 * n + i], y[n + i] += dt * y[3 * n + i];
        }
    }

    ImplicitAngle<NoFriction> system;

  private:
    std::vector<double> dy_;
};

}  // namespace serpenoid
