// Which terms a scene has: the force of its ground, and which joints are not imposed.
#pragma once

#include "drive/joint_angles.hpp"
#include "model/ground_force.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

inline GroundForce ground_force(const RunRequest& q) { return {q.ground, q.slope, q.robot.m}; }

// Whether any joint is not imposed: driven by a torque, limp or locked.
inline bool mixed(const RunRequest& q) { return q.drive != Drive::angle || !q.faults.empty(); }

inline MixedDrive mixed_drive(const RunRequest& q) {
    return {q.robot.n, q.gait, q.drive == Drive::angle, q.faults, q.locked_rad, armature(q)};
}

}  // namespace serpenoid
