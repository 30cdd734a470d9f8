// Robot, ground and gait in SI units and radians; Python has checked the ranges.
#pragma once

#include <vector>

#include "model/friction_law.hpp"

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
