// Robot, slope and gait in SI units and radians. Python has checked their ranges.
#pragma once

#include <vector>

#include "model/friction_law.hpp"

// For small functions that right-hand sides call in their loops. A translation unit has dozens of
// instances of these templates. Without this attribute the compiler does not inline all of them,
// and the calls cost a tenth of the time.
#define INLINED [[gnu::always_inline]] inline

namespace serpenoid {

// A chain of n equal rigid links, counted from the tail.
struct Robot {
    int n;     // links, 2 or more
    double m;  // mass of a link, kg
    double l;  // HALF the length of a link, m (the paper's l)
    double I;  // moment of inertia of a link about its centre, kg m^2
};

// Component of gravity in the plane of the ground, m/s^2, in the ground frame; 0 on level ground.
struct Slope {
    double gx = 0, gy = 0;
};

// Joint angles phi_i = offset + gain_i alpha sin(omega t + (i - 1) beta + shift_i), i = 1..n-1;
// Eq. 57 has gains of 1 and shifts of 0, for which the lists are empty.
struct Gait {
    double alpha, beta;  // rad
    double omega;        // rad/s
    double offset;       // rad
    std::vector<double> gain{}, shift{};
};

}  // namespace serpenoid
