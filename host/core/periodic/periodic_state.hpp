// The periodic state of a gait, explicit model: what is asked for, what comes back, and when it is
// good enough.
#pragma once

#include <algorithm>
#include <cmath>

#include "model/params.hpp"
#include "numerics/dense.hpp"

namespace serpenoid {

struct SteadyOptions {
    double rtol;  // of the speed, and of the powers when they are asked for
    bool powers;  // also the means of |P_i| and P_i^+, which need every joint torque
    // Dry ground: the first tolerance will do, whose errors are not known. Viscous ground: the
    // multipliers need not be known.
    bool rough = false;
};

// Speeds in m/s, powers in W, averaged over a period once the start is forgotten.
//
// The path of a gait that turns: every cycle turns it by the same angle about one centre. In axes
// that turn evenly, Omega = turn / period, the place is periodic about that centre, and its mean,
// which is the same from any phase, goes round the mean circle. The mean of the velocity in those
// axes is Omega x (mean place): it is the speed along the circle, radius times Omega. For a gait
// that does not turn it is the displacement of a period over the period. The chord of one period
// differs from phase to phase, because the body swings about the circle.
struct SteadyState {
    double speed = 0;      // along the mean circle (a straight line when the gait does not turn)
    double chord = 0;      // |displacement over the period from phase 0| / period
    double power = 0;      // net mean of -sum T_i phi_i'; equals the mean dissipation
    double abs_power = 0;  // mean of sum |T_i phi_i'|
    double positive_power = 0;  // mean of sum max(-T_i phi_i', 0)
    double turn = 0;            // change of heading per cycle, rad
    double direction = 0;       // direction of travel from the heading of link 1 at phase 0, rad
    double speed_error = 0;     // error bounds, same units as the quantity
    double power_error = 0;
    double positive_power_error = 0;
    double turn_error = 0;
    Vec3 start{};      // u = (Vx, Vy, w) in the body frame at phase 0; m/s, m/s, rad/s
    Mat3 monodromy{};  // d(state after a period)/d(state) in (Vx, Vy, L)
    double log_largest_multiplier = 0;  // logarithm of the largest Floquet multiplier's size
    double log_multiplier_error = 0;
    bool converged = false;

    // A state of which nothing is known: every error is infinite.
    static SteadyState unknown();
};

// A speed's error counts relative to the speed, or to this part of body length times omega where
// the speed is less: a gait that only swings has no speed to compare with.
constexpr double kSpeedFloor = 1e-4;

// The one rule by which a state is good enough. An error of positive power never refuses a state:
// it stands beside the value.
struct Acceptance {
    Acceptance(const SteadyOptions& options, const Robot& robot, const Ground& ground,
               double omega);

    // How many times the errors of speed and net power are what is asked for; at most 1 is good
    // enough.
    double excess(const SteadyState& s) const;
    bool operator()(const SteadyState& s) const { return excess(s) <= 1; }

    double rtol;
    double power_rtol;   // on dry ground 10 rtol, for kinks of the torques limit powers
    double speed_floor;  // m/s
};

// A stated error is never less than a small part of what was asked for: levels may agree by luck.
inline double stated_error(double error, double rtol, double value) {
    return std::max(error, 1e-3 * rtol * std::fabs(value));
}

}  // namespace serpenoid
