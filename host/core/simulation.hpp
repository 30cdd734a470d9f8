// A run in time: what is asked for and what is recorded.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "implicit_model.hpp"
#include "params.hpp"

namespace serpenoid {

enum class Formulation { explicit_, implicit };
enum class Drive { angle, torque };
enum class Method { rk4, nonsmooth };

// Torque of every joint at time t, N m; throws through the run when it fails.
using TorqueFunction = std::function<void(double t_s, double* torque_nm)>;

struct RunRequest {
    Robot robot;
    Ground ground;
    Gait gait;
    Formulation formulation = Formulation::explicit_;
    Drive drive = Drive::angle;
    Method method = Method::rk4;
    JointSpring spring{1e3, 1.0};
    double smoothing = 0;  // m/s; above 0 the dry friction is smoothed, by name
    TorqueFunction torque;
    double dt = 1e-3;
    double duration = 0;  // s; the last step is shorter where dt does not divide it
    long steps = 0;
    long every = 1;  // record each of so many steps
    bool record_joints = false;
    std::vector<double> start;  // x, y, theta, vx, vy, omega: n values each
};

// Rows of n (or n-1) values, one row a recorded time; SI units, ground frame.
struct RunResult {
    std::vector<double> t, x, y, theta, vx, vy, omega;
    std::vector<double> joint_fx, joint_fy, joint_torque;
    double failed_at = -1;  // time at which the state left the finite numbers
};

RunResult simulate(const RunRequest& request);

// One evaluation: fills accelerations, friction and joints of a chain whose angles, rates,
// positions and velocities are given; `bend` is phi'' (angle drive), joints.T the torques (torque
// drive).
void evaluate(const RunRequest& request, const double* bend, Chain& chain, Joints& joints);

}  // namespace serpenoid
