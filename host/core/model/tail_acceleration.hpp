// How link 1 accelerates when all joint angles are imposed: three equations, summed link by link.
//
// With r_i = c_i - c_1, s_i'' = sum of phi_j'' for j < i, and
//     a_i = a_1 + theta_1'' z x r_i + b_i,   b_1 = 0,
//     b_{i+1} = b_i + l(s_i'' n_i - w_i^2 t_i + s_{i+1}'' n_{i+1} - w_{i+1}^2 t_{i+1}),
// the sums of force and of moment about c_1 over all links are
//     nm x'' - m R_y theta_1'' = sum f_x - m B_x,    nm y'' + m R_x theta_1'' = sum f_y - m B_y,
//     m (R_x y'' - R_y x'') + J theta_1'' = sum r x (f - m b) - I sum s'',
// R = sum r, B = sum b, J = n I + m sum |r|^2; x'' and y'' are eliminated first.
#pragma once

#include "model/params.hpp"

namespace serpenoid {

// The head joint relative to the centre of its link: place, and the known part of the acceleration.
struct HalfLink {
    double x, y, ax, ay;
};

INLINED HalfLink half_link(double l, double c, double s, double rate, double accel) {
    const double x = l * c, y = l * s, square = rate * rate;
    return {x, y, -accel * y - square * x, accel * x - square * y};
}

// r_i, b_i and s_i'' on the way from link to link.
struct LinkPath {
    double x, y, b_x, b_y, turn;
    INLINED void pass(const HalfLink& a, const HalfLink& b) {
        x += a.x + b.x;
        y += a.y + b.y;
        b_x += a.ax + b.ax;
        b_y += a.ay + b.ay;
    }
};

struct TailMotion {
    double ax, ay, alpha;
};

struct TailSums {
    double fx, fy;  // at first those of link 1, which adds nothing else
    double moment = 0, Rx = 0, Ry = 0, square = 0, turns = 0;

    // Add a link with the force of the ground on it.
    INLINED void add(double m, const LinkPath& k, double force_x, double force_y) {
        const double gx = force_x - m * k.b_x, gy = force_y - m * k.b_y;
        fx += gx;
        fy += gy;
        moment += k.x * gy - k.y * gx;
        Rx += k.x, Ry += k.y, square += k.x * k.x + k.y * k.y, turns += k.turn;
    }
    INLINED TailMotion solve(const Robot& r) const {
        const double share = 1.0 / r.n;  // eliminate x'' and y'': the inertia about the centre
        const double J = r.n * r.I + r.m * (square - share * (Rx * Rx + Ry * Ry));
        const double alpha = (moment - r.I * turns + share * (Ry * fx - Rx * fy)) / J;
        const double mass = r.n * r.m;
        return {(fx + r.m * Ry * alpha) / mass, (fy - r.m * Rx * alpha) / mass, alpha};
    }
};

}  // namespace serpenoid
