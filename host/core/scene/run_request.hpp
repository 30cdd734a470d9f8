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
    TorqueFunction torque;  // Drive::torque uses this function, or else the table
    TorqueRows table;
    Servo servo{};
    std::vector<Fault> faults;       // one for each joint; empty: no faults
    std::vector<double> locked_rad;  // angles of the locked joints
    MethodKind method = kMethods[0];
    double dt = 1e-3;            // fixed step, and unit of the output times, s
    double tolerance = 1e-6;     // tolerance of adaptive methods
    double duration = 0;         // s; the last step may be shorter than dt
    long long steps = 0;         // number of steps dt in the duration
    long long max_steps = 0;     // number of steps of any length after which the run fails
    long long record_steps = 1;  // number of steps dt between two output times
    bool record_joints = false, record_friction = false, record_energy = false;
    std::vector<double> start;                   // x, y, theta, vx, vy, omega: n values each
    std::function<bool(double t)> keep_running;  // called often; false stops the run
};

// Armature of the servos, kg m^2, and friction of their gears, N m; 0 for other drives.
inline double armature(const RunRequest& request) {
    return request.drive == Drive::servo ? request.servo.armature : 0;
}
inline double gear_friction(const RunRequest& request) {
    return request.drive == Drive::servo ? request.servo.gear_friction : 0;
}

// Unit of a motion's rates, 1/s: the gait's omega; with other drives at least 1.
inline double rate_unit(const RunRequest& request) {
    return request.drive == Drive::angle ? request.gait.omega : std::max(request.gait.omega, 1.0);
}

// The tolerance within a mode. It is tighter than that of the run, because the end of a mode
// amplifies earlier errors, but not below rounding, which grows with the number of links. With
// joints driven by torques there is no such amplification.
inline double mode_tolerance(const RunRequest& request) {
    if (request.drive != Drive::angle) return request.tolerance;
    const double n = request.robot.n;
    const double rounding = 1e-13 * std::max(1.0, n * n * n / 27);
    return std::max(request.tolerance / 300,
                    std::min(request.tolerance, std::sqrt(request.tolerance * rounding)));
}

// The plain numbers of a Scene in Python, by their names there; they are passed on unchanged.
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

// The chain at the start of a run.
inline Chain start_chain(const RunRequest& request) {
    const int n = request.robot.n;
    Chain c(n);
    std::vector<double>* parts[6] = {&c.x, &c.y, &c.theta, &c.vx, &c.vy, &c.omega};
    for (int p = 0; p < 6; ++p) std::copy_n(request.start.begin() + p * n, n, parts[p]->begin());
    c.directions();
    return c;
}

// Arrays of rows, one row for each output time, of n, n-1 or 6 values; SI units, ground frame.
struct RunResult {
    std::vector<double> t, x, y, theta, vx, vy, omega;
    std::vector<double> joint_fx, joint_fy, joint_torque, friction_x, friction_y;
    std::vector<double> energy;  // rows of energy_ledger.hpp
    double failed_at = -1;       // time at which the state is no longer finite, s; -1: never
    std::string why;             // cause, if the method failed
    long long steps = 0;         // number of steps taken
    double error = 0;            // sum of the method's local errors, in the unit of its tolerance
};

}  // namespace serpenoid
