// The ground's force on the links, composed at compile time: a friction law and, on tilted ground,
// the weight. Terms that a scene lacks are not compiled: no compiler may drop 0 * x.
#pragma once

#include <type_traits>

#include "model/chain.hpp"
#include "model/friction_law.hpp"

namespace serpenoid {

struct Flat {};
struct Tilted {};

// The force on every link of a chain. One virtual call a chain: most systems are compiled once and
// not once a law.
struct ChainForce {
    virtual ~ChainForce() = default;
    virtual void operator()(Chain& k) const = 0;
};

template <class Law, class Plane>
struct GroundForce final : ChainForce {
    GroundForce(const Ground& g, const Slope& s, double m)
        : law(g), weight_x(m * s.gx), weight_y(m * s.gy) {}

    struct Pair {
        double x, y;
    };

    // Friction (Eqs. 28-33) and weight on a link of direction (c, s) and velocity (vx, vy).
    INLINED Pair on(double c, double s, double vx, double vy) const {
        Pair f{0, 0};
        if constexpr (!std::is_same_v<Law, Frictionless>) {
            const double ft = law.along(c * vx + s * vy);
            const double fn = law.across(c * vy - s * vx);
            f = {ft * c - fn * s, ft * s + fn * c};
        }
        if constexpr (std::is_same_v<Plane, Tilted>) f.x += weight_x, f.y += weight_y;
        return f;
    }
    void operator()(Chain& k) const override {
        for (int i = 0; i < k.n(); ++i) {
            const Pair f = on(k.c[i], k.s[i], k.vx[i], k.vy[i]);
            k.fx[i] = f.x, k.fy[i] = f.y;
        }
    }

    Law law;
    double weight_x, weight_y;  // N, of one link along the plane
};

}  // namespace serpenoid
