// Friction of one wheel direction: the law as a whole, and the types with which a model is
// compiled.
//
// What a solver needs of the law (force, dissipation, bounds at rest, slope) stands here.
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
        : bound(f0 == f0_back ? f0 : 0.5 * (f0 + f0_back)),
          thrust(0.5 * (f0_back - f0)),
          c_(c),
          c_back_(c_back),
          f0_(f0),
          f0_back_(f0_back) {}

    static WheelLaw along(const Ground& g) { return {g.ct, g.ct_back, g.ft0, g.ft0_back}; }
    static WheelLaw across(const Ground& g) { return {g.cn, g.cn, g.fn0, g.fn0}; }

    double bound, thrust;  // N

    // c by the direction in which the wheel goes, N s/m; 0: at rest, the mean of both.
    double viscous(double direction) const {
        return direction > 0 ? c_ : direction < 0 ? c_back_ : mean_viscous();
    }
    double mean_viscous() const { return c_ == c_back_ ? c_ : 0.5 * (c_ + c_back_); }
    bool one_viscous() const { return c_ == c_back_; }  // the same both ways

    // F0 by the direction in which the wheel goes or would go, N.
    double dry(double direction) const { return direction < 0 ? f0_back_ : f0_; }
    double most_dry() const { return std::max(f0_, f0_back_); }

    // Whether something changes when the wheel stops.
    bool has_modes() const { return bound > 0 || !one_viscous(); }

    // The bound over the scale of forces on a wheel at rest: its weaker end, or the force that
    // `moves` the links if that is larger, but at most the stronger end.
    double grip(double moves) const {
        if (f0_ == f0_back_) return 1;
        const double weak = std::min(f0_, f0_back_), strong = std::max(f0_, f0_back_);
        return bound / std::min(strong, std::max(weak, moves));
    }

    // The least force at which a wheel that rests gives way; 0 without dry friction.
    double least() const {
        if (f0_ == 0 || f0_back_ == 0) return most_dry();
        return std::min(f0_, f0_back_);
    }

  private:
    double c_, c_back_, f0_, f0_back_;
};

// The least force at which any wheel gives way; 0 without dry friction.
inline double least_dry(const Ground& g) {
    const double t = WheelLaw::along(g).least(), n = WheelLaw::across(g).least();
    return t == 0 || n == 0 ? std::max(t, n) : std::min(t, n);
}

// No friction at all, for which momentum is conserved.
struct Frictionless {
    explicit Frictionless(const Ground&) {}
    double along(double) const { return 0; }
    double across(double) const { return 0; }
};

// Force = -(c v): Eqs. 28 and 29 with the sign that opposes motion.
struct Viscous {
    explicit Viscous(const Ground& g) : ct(g.ct), cn(g.cn) {}
    double along(double v) const { return -ct * v; }
    double across(double v) const { return -cn * v; }
    double ct, cn;
};

inline double sgn(double v) { return (v > 0) - (v < 0); }

// Force = -F0 sgn v with sgn 0 = 0: a single evaluation, which knows nothing of sticking.
struct Coulomb {
    explicit Coulomb(const Ground& g) : ft0(g.ft0), fn0(g.fn0) {}
    double along(double v) const { return -ft0 * sgn(v); }
    double across(double v) const { return -fn0 * sgn(v); }
    double ft0, fn0;
};

// Force = -(c v + F0 sgn v) with sgn 0 = 0 (Eqs. 59 and 62).
struct Bingham {
    explicit Bingham(const Ground& g) : ground(g) {}
    double along(double v) const { return -(ground.ct * v + ground.ft0 * sgn(v)); }
    double across(double v) const { return -(ground.cn * v + ground.fn0 * sgn(v)); }
    Ground ground;
};

// Bingham's law with other coefficients backwards.
struct Ratchet {
    explicit Ratchet(const Ground& g) : ground(g) {}
    double along(double v) const {
        if (v < 0) return ground.ft0_back - ground.ct_back * v;
        return v > 0 ? -(ground.ft0 + ground.ct * v) : 0;
    }
    double across(double v) const { return -(ground.cn * v + ground.fn0 * sgn(v)); }
    Ground ground;
};

}  // namespace serpenoid
