// Positions, velocities and forces of all links in the ground's frame, for all models.
#pragma once

#include <algorithm>
#include <vector>

#include "model/params.hpp"
#include "numerics/pack.hpp"

namespace serpenoid {

// Between the ends of two links at a joint of the implicit model, and its rate.
struct Gap {
    double x, y, vx, vy;
};

// Arrays over the links, SI units; accelerations are results, forces are those of the ground.
struct Chain {
    explicit Chain(int n)
        : x(n),
          y(n),
          theta(n),
          vx(n),
          vy(n),
          omega(n),
          ax(n),
          ay(n),
          alpha(n),
          fx(n),
          fy(n),
          c(n + n % kPack),
          s(n + n % kPack) {}
    int n() const { return static_cast<int>(x.size()); }

    void directions() {
        for (int i = 0; i < n(); i += kPack)
            sincos(Pack{theta[i], theta[std::min(i + 1, n() - 1)]}, pack_at(&s[i]), pack_at(&c[i]));
    }

    // The ground's forces on all links, by their directions and velocities (Eqs. 28-33); the weight
    // of a link along the plane, N.
    void apply_ground(const Ground& ground, double weight_x, double weight_y) {
        for (int i = 0; i < n(); ++i) {
            const double ft = ground.along.force(c[i] * vx[i] + s[i] * vy[i]);
            const double fn = ground.across.force(c[i] * vy[i] - s[i] * vx[i]);
            fx[i] = ft * c[i] - fn * s[i] + weight_x;
            fy[i] = ft * s[i] + fn * c[i] + weight_y;
        }
    }

    // Positions and velocities of all links from those of link 1 and all angles (Eqs. 10-21), and
    // from the gaps where joints are springs.
    void follow(double l, const Gap* gaps = nullptr) {
        double px = x[0], py = y[0], ux = vx[0], uy = vy[0];
        for (int i = 0; i + 1 < n(); ++i) {
            px += l * (c[i] + c[i + 1]);
            py += l * (s[i] + s[i + 1]);
            ux -= l * (omega[i] * s[i] + omega[i + 1] * s[i + 1]);
            uy += l * (omega[i] * c[i] + omega[i + 1] * c[i + 1]);
            if (gaps) {
                px += gaps[i].x;
                py += gaps[i].y;
                ux += gaps[i].vx;
                uy += gaps[i].vy;
            }
            x[i + 1] = px;
            y[i + 1] = py;
            vx[i + 1] = ux;
            vy[i + 1] = uy;
        }
    }

    std::vector<double> x, y, theta, vx, vy, omega, ax, ay, alpha, fx, fy, c, s;
};

// Forces and torques of the joints: on link i from link i+1, i = 0..n-2.
struct Joints {
    explicit Joints(int n) : Fx(n - 1), Fy(n - 1), T(n - 1) {}
    std::vector<double> Fx, Fy, T;
};

}  // namespace serpenoid
