// The request for a run, and its result.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "drive/joint_angles.hpp"
#include "drive/torque_source.hpp"
#include "model/implicit_model.hpp"
#include "model/params.hpp"
#include "scene/method_table.hpp"

namespace serpenoid {

enum class Formulation { explicit_, implicit };
enum class Drive { angle, torque, servo };

struct RunRequest {
    Robot robot{};
    Ground ground{};
    Gait gait{};
    Slope slope{};
    Formulation formulation = Formulation::explicit_;
    JointSpring spring{1e3, 1.0};
    Drive drive = Drive::angle;
    TorqueFunction torque;  // drive torque has one of these two
    TorqueRows table;
    Servo servo{};
    std::vector<Fault> faults;       // one a joint; empty: all sound
    std::vector<double> locked_rad;  // angles of the locked joints
    MethodKind method = kMethods[0];
    double dt = 1e-3;            // s; fixed step, and grid of the recorded times
    double tolerance = 1e-6;     // of adaptive methods
    double duration = 0;         // s; the last step is shorter where dt does not divide it
    long long steps = 0;         // of dt in the duration
    long long most_steps = 0;    // of any length, after which the run gives up
    long long record_steps = 1;  // record each of so many steps
    bool record_joints = false, record_friction = false, record_energy = false;
    std::vector<double> start;                   // x, y, theta, vx, vy, omega: n values each
    std::function<bool(double t)> keep_running;  // asked now and then; false stops the run
};

// The rotors of its servos, kg m^2; 0 for other drives.
inline double armature(const RunRequest& request) {
    return request.drive == Drive::servo ? request.servo.armature : 0;
}
inline double gear_friction(const RunRequest& request) {
    return request.drive == Drive::servo ? request.servo.gear_friction : 0;
}

// Unit of a motion's rates, 1/s: that of the gait; with other drives at least 1.
inline double rate_unit(const RunRequest& request) {
    return request.drive == Drive::angle ? request.gait.omega : std::max(request.gait.omega, 1.0);
}

// The tolerance inside a mode: its end magnifies the errors before it. Rounding grows with the
// links. Joints that are driven by torques give way, and it need not be so tight.
inline double mode_tolerance(const RunRequest& request) {
    if (request.drive != Drive::angle) return request.tolerance;
    const double n = request.robot.n;
    const double rounding = 1e-13 * std::max(1.0, n * n * n / 27);
    return std::max(request.tolerance / 300,
                    std::min(request.tolerance, std::sqrt(request.tolerance * rounding)));
}

// The fields that a Scene of Python has as plain numbers, under its names: handed over as they are.
template <class Visit>
void each_scene_field(const Visit& field) {
    using Q = RunRequest&;
    field("joint_stiffness_n_m", [](Q request) -> double& { return request.spring.k; });
    field("joint_damping_n_s_m", [](Q request) -> double& { return request.spring.c; });
    field("dt_s", [](Q request) -> double& { return request.dt; });
    field("tolerance", [](Q request) -> double& { return request.tolerance; });
    field("duration_s", [](Q request) -> double& { return request.duration; });
    field("steps", [](Q request) -> long long& { return request.steps; });
    field("record_steps", [](Q request) -> long long& { return request.record_steps; });
}

// The chain at the start of a run, with its directions.
inline Chain start_chain(const RunRequest& request) {
    const int n = request.robot.n;
    Chain c(n);
    std::vector<double>* parts[6] = {&c.x, &c.y, &c.theta, &c.vx, &c.vy, &c.omega};
    for (int p = 0; p < 6; ++p) std::copy_n(request.start.begin() + p * n, n, parts[p]->begin());
    c.directions();
    return c;
}

// Rows of n (or n-1, or 6) values, one row a recorded time; SI units, ground frame.
struct RunResult {
    std::vector<double> t, x, y, theta, vx, vy, omega;
    std::vector<double> joint_fx, joint_fy, joint_torque, friction_x, friction_y;
    std::vector<double> energy;  // rows of energy_ledger.hpp
    double failed_at = -1;       // time by which the state left the finite numbers, or:
    std::string why;             // why the method gave up
    long long steps = 0;         // taken
    double error = 0;            // sum of the method's local errors, in the scale of its tolerance
};

}  // namespace serpenoid
