// The mean speed of a gait with servos, over all phases between frames and gait.
//
// Joints forget their start within a cycle; the body's three velocities need m/c seconds and more.
// A secant method (Broyden's) takes them to the fixed point of the cycle's map; it starts with the
// derivative that the periodic state of ideal joints has. Frames and gait have no common period:
// the answer is the mean of cycles whose frames begin at phases spread over a frame.
#pragma once

#include <cmath>
#include <vector>

#include "drive/servo.hpp"
#include "model/params.hpp"
#include "numerics/dense.hpp"

namespace serpenoid {

struct ServoGaitOptions {
    double longest = 2e-3;     // step, s
    int phases = 4;            // of the frames in the gait, where they are few
    int most_halvings = 2;     // of the step, where the speed hangs on it
    double rtol = 1e-2;        // by how much it may, relative
    int most_cycles = 60;      // to settle in
    double settled = 2e-3;     // of the speed: how far from the fixed point it may be
    bool rough = false;        // for searches: the long steps alone, half the phases, no error
    std::vector<int> watch{};  // harmonics of the gait to look for in the joints' rates
};

struct ServoGaitState {
    double speed = NAN;  // m/s, mean over the phases; NaN where steps would be far too many
    double spread = 0;   // half the range over the phases
    double error = 0;    // estimated, of `speed`
    double turn = 0, power = 0, amplitude = 0, lag = 0, ripple = 0;  // as ServoSteps::Path
    std::vector<double> gain{}, shift{};  // of each joint, as ServoSteps::Path, last phase
    std::vector<double> lines{};  // rms of the rates in each watched harmonic, rad/s, last phase
    int cycles = 0;
    bool converged = false;
};

// `start`: (Vx, Vy, rate) at phase 0 and `monodromy` of ideal joints (periodic_state.hpp).
ServoGaitState servo_gait(const Robot& robot, const Ground& ground, const Gait& gait,
                          const Servo& servo, const Vec3& start, const Mat3& monodromy,
                          const ServoGaitOptions& options);

}  // namespace serpenoid
