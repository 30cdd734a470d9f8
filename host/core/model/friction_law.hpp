// Friction of one wheel direction as types, so that a model is compiled with the law that it has.
#pragma once

#include <cmath>

#include "model/params.hpp"

namespace serpenoid {

// No friction at all, for which momentum is conserved.
struct Frictionless {
    explicit Frictionless(const Ground&, double = 0) {}
    double along(double) const { return 0; }
    double across(double) const { return 0; }
};

// Force = -(c v): Eqs. 28 and 29 with the sign that opposes motion.
struct Viscous {
    explicit Viscous(const Ground& g, double = 0) : ct(g.ct), cn(g.cn) {}
    double along(double v) const { return -ct * v; }
    double across(double v) const { return -cn * v; }
    double ct, cn;
};

inline double sgn(double v) { return (v > 0) - (v < 0); }

// Force = -F0 sgn v with sgn 0 = 0: a single evaluation, which knows nothing of sticking.
struct Coulomb {
    explicit Coulomb(const Ground& g, double = 0) : ft0(g.ft0), fn0(g.fn0) {}
    double along(double v) const { return -ft0 * sgn(v); }
    double across(double v) const { return -fn0 * sgn(v); }
    double ft0, fn0;
};

// Force = -(c v + F0 sgn v) with sgn 0 = 0 (Eqs. 59 and 62).
struct Bingham {
    explicit Bingham(const Ground& g, double = 0) : ground(g) {}
    double along(double v) const { return -(ground.ct * v + ground.ft0 * sgn(v)); }
    double across(double v) const { return -(ground.cn * v + ground.fn0 * sgn(v)); }
    Ground ground;
};

// sgn v replaced by v / sqrt(v^2 + width^2): for study only, it makes sticking creep.
struct Smoothed {
    Smoothed(const Ground& g, double width_m_s) : ground(g), square(width_m_s * width_m_s) {}
    double soft(double v) const { return v / std::sqrt(v * v + square); }
    double along(double v) const { return -(ground.ct * v + ground.ft0 * soft(v)); }
    double across(double v) const { return -(ground.cn * v + ground.fn0 * soft(v)); }
    Ground ground;
    double square;
};

// Bingham's law with wheels that roll backwards another way than forwards.
struct Ratchet {
    explicit Ratchet(const Ground& g, double = 0) : ground(g) {}
    double along(double v) const {
        if (v < 0) return ground.ft0_back - ground.ct_back * v;
        return v > 0 ? -(ground.ft0 + ground.ct * v) : 0;
    }
    double across(double v) const { return -(ground.cn * v + ground.fn0 * sgn(v)); }
    Ground ground;
};

// The same, smoothed: with s = v / sqrt(v^2 + width^2) in place of the sign, coefficients go over
// from backwards to forwards as s goes from -1 to 1; the force never drives.
struct SmoothedRatchet : Smoothed {
    SmoothedRatchet(const Ground& g, double width_m_s)
        : Smoothed(g, width_m_s),
          ct_half(0.5 * (g.ct - g.ct_back)),
          ft0_half(0.5 * (g.ft0 - g.ft0_back)) {
        ground.ct = g.ct_mean(), ground.ft0 = g.ft0_mean();
    }
    double along(double v) const {
        const double s = soft(v);
        return -((ground.ct + ct_half * s) * v + (ground.ft0 + ft0_half * s) * s);
    }
    double ct_half, ft0_half;
};

}  // namespace serpenoid
