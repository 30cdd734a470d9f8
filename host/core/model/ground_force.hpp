// The ground's force on the links of a chain: friction and, on tilted ground, the weight.
#pragma once

#include "model/chain.hpp"
#include "model/friction_law.hpp"

namespace serpenoid {

class GroundForce {
  public:
    GroundForce(const Ground& ground, const Slope& slope, double link_mass)
        : along_(WheelLaw::along(ground)),
          across_(WheelLaw::across(ground)),
          weight_x_(link_mass * slope.gx),
          weight_y_(link_mass * slope.gy) {}

    // Fill the forces of a chain that has its directions and velocities (Eqs. 28-33).
    void operator()(Chain& chain) const {
        for (int i = 0; i < chain.n(); ++i) {
            const double c = chain.c[i], s = chain.s[i];
            const double ft = along_.force(c * chain.vx[i] + s * chain.vy[i]);
            const double fn = across_.force(c * chain.vy[i] - s * chain.vx[i]);
            chain.fx[i] = ft * c - fn * s + weight_x_;
            chain.fy[i] = ft * s + fn * c + weight_y_;
        }
    }

  private:
    WheelLaw along_, across_;
    double weight_x_, weight_y_;  // N, of one link along the plane
};

}  // namespace serpenoid
