// What the ground does to the links, composed at compile time: a friction law, and the weight if
// the ground is tilted. A term that a scene has not is not in its code (a product with zero would
// be: no compiler may drop 0 * x).
#pragma once

#include <type_traits>

#include "chain.hpp"
#include "friction_law.hpp"

namespace serpenoid {

struct Flat {};
struct Tilted {};

template <class Law, class Plane>
struct GroundForce {
    GroundForce(const Ground& g, double smoothing, const Slope& s, double m)
        : law(g, smoothing), weight_x(m * s.gx), weight_y(m * s.gy) {}

    // Fill the force on every link: friction (Eqs. 28-33) and weight.
    void operator()(Chain& k) const {
        for (int i = 0; i < k.n(); ++i) {
            double fx = 0, fy = 0;
            if constexpr (!std::is_same_v<Law, Frictionless>) {
                const double c = k.c[i], s = k.s[i];
                const double ft = law.along(c * k.vx[i] + s * k.vy[i]);
                const double fn = law.across(-s * k.vx[i] + c * k.vy[i]);
                fx = ft * c - fn * s, fy = ft * s + fn * c;
            }
            if constexpr (std::is_same_v<Plane, Tilted>) fx += weight_x, fy += weight_y;
            k.fx[i] = fx, k.fy[i] = fy;
        }
    }

    Law law;
    double weight_x, weight_y;  // N, of one link along the plane
};

}  // namespace serpenoid
