// A run in time: composed, stepped by its method, recorded.
#pragma once

#include "chain.hpp"
#include "run_request.hpp"

namespace serpenoid {

RunResult simulate(const RunRequest& request);

// One evaluation: fills accelerations, friction and joints of a chain whose angles, rates,
// positions and velocities are given; `bend` is phi'' (angle drive), joints.T the torques (torque
// drive).
void evaluate(const RunRequest& request, const double* bend, Chain& chain, Joints& joints);

}  // namespace serpenoid
