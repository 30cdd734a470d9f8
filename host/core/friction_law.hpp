// Friction of one wheel direction as types, so that a model is compiled with the law that it has.
#pragma once

#include <cmath>

#include "params.hpp"

namespace serpenoid {

// Force = -(c v): Eqs. 28 and 29 with the sign that opposes motion.
struct Viscous {
    static constexpr bool dry = false;
    explicit Viscous(const Ground& g, double = 0) : ct(g.ct), cn(g.cn) {}
    double along(double v) const { return -ct * v; }
    double across(double v) const { return -cn * v; }
    double ct, cn;
};

// Force = -(c v + F0 sgn v) with sgn 0 = 0: a single evaluation, which knows nothing of sticking.
struct Dry {
    static constexpr bool dry = true;
    explicit Dry(const Ground& g, double = 0) : ground(g) {}
    static double sgn(double v) { return (v > 0) - (v < 0); }
    double along(double v) const { return -(ground.ct * v + ground.ft0 * sgn(v)); }
    double across(double v) const { return -(ground.cn * v + ground.fn0 * sgn(v)); }
    Ground ground;
};

// sgn v replaced by v / sqrt(v^2 + width^2): for study only, it makes sticking creep.
struct Smoothed {
    static constexpr bool dry = true;
    Smoothed(const Ground& g, double width_m_s) : ground(g), square(width_m_s * width_m_s) {}
    double soft(double v) const { return v / std::sqrt(v * v + square); }
    double along(double v) const { return -(ground.ct * v + ground.ft0 * soft(v)); }
    double across(double v) const { return -(ground.cn * v + ground.fn0 * soft(v)); }
    Ground ground;
    double square;
};

}  // namespace serpenoid
