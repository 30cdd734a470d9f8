// One evaluation: fills accelerations, friction and joints of a chain whose angles, rates,
// positions and velocities are given.
#pragma once

#include "model/chain.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

// `joint_acceleration` is phi'' (angle drive); joints.T holds the torques (torque drive).
void evaluate(const RunRequest& request, const double* joint_acceleration, Chain& chain,
              Joints& joints);

}  // namespace serpenoid
