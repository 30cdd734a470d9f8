// Friction of one wheel direction: its force, and what a solver needs of the law (bounds at rest,
// coefficients by the direction).
#pragma once

#include <algorithm>
#include <cmath>

#include "model/params.hpp"

namespace serpenoid {

// The set-valued law of one direction of a wheel: the force -(c v + F0 sgn v), with c and F0 by the
// sign of v, and at rest any force between both ends. At rest the force is thrust - bound s with s
// in [-1, 1]; where the wheel slides, s is the sign of v. A step that keeps c has the potential
// c v^2/2 + bound |v| - thrust v, whose minimum convex problems look for.
class WheelLaw {
  public:
    WheelLaw(double c, double c_back, double f0, double f0_back)
        : bound(0.5 * (f0 + f0_back)),
          thrust(0.5 * (f0_back - f0)),
          c_(c),
          c_back_(c_back),
          f0_(f0),
          f0_back_(f0_back) {}

    static WheelLaw along(const Ground& g) { return {g.ct, g.ct_back, g.ft0, g.ft0_back}; }
    static WheelLaw across(const Ground& g) { return {g.cn, g.cn, g.fn0, g.fn0}; }

    double bound, thrust;  // N

    // The force at a speed, with sgn 0 = 0 (Eqs. 28, 29, 59 and 62): a single evaluation, which
    // knows nothing of sticking.
    double force(double speed) const {
        const double dry_force = speed > 0 ? f0_ : speed < 0 ? -f0_back_ : 0;
        return -((speed < 0 ? c_back_ : c_) * speed + dry_force);
    }

    // c by the direction in which the wheel goes, N s/m; 0: at rest, the mean of both.
    double viscous(double direction) const {
        return direction > 0 ? c_ : direction < 0 ? c_back_ : mean_viscous();
    }
    double mean_viscous() const { return 0.5 * (c_ + c_back_); }

    // F0 by the direction in which the wheel goes or would go, N.
    double dry(double direction) const { return direction < 0 ? f0_back_ : f0_; }

    // Whether something changes when the wheel stops.
    bool has_modes() const { return bound > 0 || c_ != c_back_; }

    // The bound over the scale of forces on a wheel at rest: its weaker end, or the force that
    // would move the links if that is larger, but at most the stronger end.
    double breakaway_ratio(double force_scale) const {
        if (f0_ == f0_back_) return 1;
        const double weak = std::min(f0_, f0_back_), strong = std::max(f0_, f0_back_);
        return bound / std::min(strong, std::max(weak, force_scale));
    }

    // The least force at which a wheel that rests gives way; 0 without dry friction.
    double breakaway_force() const {
        if (f0_ == 0 || f0_back_ == 0) return std::max(f0_, f0_back_);
        return std::min(f0_, f0_back_);
    }

  private:
    double c_, c_back_, f0_, f0_back_;
};

// The least force at which any wheel gives way; 0 without dry friction.
inline double least_dry(const Ground& g) {
    const double t = WheelLaw::along(g).breakaway_force(),
                 n = WheelLaw::across(g).breakaway_force();
    return t == 0 || n == 0 ? std::max(t, n) : std::min(t, n);
}

}  // namespace serpenoid
