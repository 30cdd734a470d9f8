// The periodic state of a gait, explicit model: what is asked for and what comes back.
#pragma once

#include <algorithm>
#include <cmath>

#include "model/params.hpp"
#include "numerics/dense.hpp"

namespace serpenoid {

// The path of a gait that turns. Every cycle turns it by the same angle about one centre, so in
// axes that turn evenly, Omega = turn / period, the place is periodic about that centre, and its
// mean, which hangs on no phase, goes round the mean circle. The mean of the velocity in those axes
// is Omega x (mean place): it is the speed along the circle, radius Omega times, and for a gait
// that does not turn the displacement of a period over the period. The chord of one period, on the
// other hand, differs from phase to phase, as the body swings about the circle.
struct SteadyOptions {
    double rtol;       // of the speed, and of the powers when they are asked for
    bool powers;       // also the means of |P_i| and P_i^+, which need every joint torque
    int max_elements;  // of the finest mesh
};

// Speeds in m/s, powers in W, averaged over a period once the start is forgotten.
struct SteadyState {
    double speed = 0;      // along the mean circle (a straight line when the gait does not turn)
    double chord = 0;      // |displacement over the period from phase 0| / period
    double power = 0;      // net mean of -sum T_i phi_i'; equals the mean dissipation
    double abs_power = 0;  // mean of sum |T_i phi_i'|
    double positive_power = 0;  // mean of sum max(-T_i phi_i', 0)
    double turn = 0;            // change of heading per cycle, rad
    double direction = 0;       // direction of travel from the heading of link 1 at phase 0, rad
    double speed_error = 0;     // estimates, same units as the quantity
    double power_error = 0;
    double positive_power_error = 0;
    double turn_error = 0;
    Vec3 start{};        // u = (Vx, Vy, w) in the body frame at phase 0; m/s, m/s, rad/s
    Mat3 monodromy{};    // d(state after a period)/d(state) in (Vx, Vy, L)
    double slowest = 0;  // logarithm of the largest Floquet multiplier's size
    double slowest_error = 0;
    int elements = 0;    // of the mesh that gave the result (0: adaptive steps)
    int iterations = 0;  // Newton iterations or map evaluations, all meshes
    bool converged = false;
};

// Two meshes or tolerances may agree by luck: nothing finer is claimed than a part of what was
// asked for, nor than rounding.
inline void claim_no_finer(double rtol, SteadyState& s) {
    const double part = 1e-3 * rtol;
    s.speed_error = std::max(s.speed_error, part * s.speed);
    s.power_error = std::max(s.power_error, part * s.power);
    s.positive_power_error = std::max(s.positive_power_error, part * s.positive_power);
    s.turn_error = std::max(s.turn_error, part * std::fabs(s.turn) + 1e-14);
}

}  // namespace serpenoid
