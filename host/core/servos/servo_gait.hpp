// The mean speed of a gait with servos, over all phases between frames and gait.
//
// Joints forget their start within a cycle; the body's three velocities need m/c seconds and more.
// A secant method (Broyden's) takes them to the fixed point of the cycle's map; it starts with the
// derivative that the periodic state of ideal joints has. Frames and gait have no common period:
// the answer is the mean of cycles whose frames begin at phases spread over a frame.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "drive/servo.hpp"
#include "model/params.hpp"
#include "numerics/dense.hpp"
#include "periodic/periodic_state.hpp"
#include "servos/servo_steps.hpp"

namespace serpenoid {

// A mean cycle over the phases; its speed is NaN where steps would be far too many.
struct ServoGaitState : ServoSteps::Path {
    double spread = 0;  // half the range of the speed over the phases
    double error = 0;   // estimated, of `speed`
    bool converged = false;
    bool hunts = false;  // no one speed: what it is hangs on the start; a range, speed +- spread
};

// Called after every step with the work done and the work in all as far as it is known, both in
// cycles of the longest steps. It may throw to end the work.
using ServoProgress = std::function<void(double done_cycles, double all_cycles)>;

// `start`: (Vx, Vy, rate) at phase 0 and `monodromy` of ideal joints (periodic_state.hpp). Steps
// are at most `longest`, s. `rough`: for searches, long steps alone, half the phases, no error.
// `slow`: of body length times rate; a slower speed is known to a part of this one.
ServoGaitState servo_gait(const Robot& robot, const Ground& ground, const Gait& gait,
                          const Servo& servo, const Vec3& start, const Mat3& monodromy,
                          double longest, bool rough = false, double slow = kSpeedFloor,
                          const ServoProgress& progress = {});

}  // namespace serpenoid
