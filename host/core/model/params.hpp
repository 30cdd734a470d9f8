// Robot, ground and gait in SI units and radians; Python has checked the ranges.
#pragma once

#include <vector>

// For the small parts of a right-hand side: with dozens of compositions in one translation unit the
// compiler would leave calls in the loops (a tenth of their cost).
#define INLINED [[gnu::always_inline]] inline

namespace serpenoid {

// A chain of n equal rigid links, counted from the tail.
struct Robot {
    int n;     // links, 2 or more
    double m;  // mass of a link, kg
    double l;  // HALF the length of a link, m (the paper's l)
    double I;  // inertia of a link about its centre, kg m^2
};

// Friction at the centre of one link, along it (t) and across it (n); Eqs. 28, 29, 59, 62. On a
// ratchet the friction along the link is another one backwards (towards the tail).
struct Ground {
    double ct, cn;                        // viscous, N s/m
    double ft0, fn0;                      // dry, N
    double ct_back = ct, ft0_back = ft0;  // backwards
    bool dry() const { return ft0 > 0 || ft0_back > 0 || fn0 > 0; }
    bool viscous() const { return ct > 0 || ct_back > 0 || cn > 0; }
    bool ratchet() const { return ct != ct_back || ft0 != ft0_back; }
    bool smooth() const { return !dry() && ct == ct_back; }  // a smooth function of the speed
};

// Acceleration of gravity along the plane of the ground, m/s^2, ground frame; 0 on the level.
struct Slope {
    double gx = 0, gy = 0;
};

// Joint angles phi_i = offset + gain_i alpha sin(omega t + (i - 1) beta + shift_i), i = 1..n-1;
// Eq. 57, where every gain is 1 and every shift 0 (empty lists).
struct Gait {
    double alpha, beta;  // rad
    double omega;        // rad/s
    double offset;       // rad
    std::vector<double> gain{}, shift{};
};

}  // namespace serpenoid
