// The core for a page in a browser: speeds of a gait, and its motion with servos, in plain numbers.
//
// All arrays are doubles in SI units and radians. `scene` has, in this order: links, mass of a
// link, its length; ct, cn, ft0, fn0 of a link; alpha, beta, omega. A servo has the fields in the
// order of each_servo_field. The caller has checked the ranges. A function that has no answer
// returns 0.
#include <algorithm>
#include <cmath>
#include <exception>
#include <numbers>

#include "model/chain.hpp"
#include "periodic/sweep.hpp"
#include "run/simulation.hpp"
#include "servos/servo_gait.hpp"

namespace serpenoid {
namespace {

SweepShape shape_of(const double* scene) {
    const int links = static_cast<int>(scene[0]);
    const double mass = scene[1], length = scene[2];
    const double* ground = scene + 3;
    const double* gait = scene + 7;
    return {{links, mass, length / 2, mass * length * length / 12},
            {{ground[0], ground[2]}, {ground[1], ground[3]}},
            {gait[0], gait[1], gait[2], 0}};
}

Servo servo_of(const double* fields) {
    Servo servo;
    each_servo_field([&](const char*, double Servo::* field) { servo.*field = *fields++; });
    return servo;
}

// Link 1 at the origin along x and the joints where the gait has them at first, all at rest.
std::vector<double> resting_start(const SweepShape& shape) {
    const int n = shape.robot.n;
    Chain chain(n);
    const GaitTable table(n, shape.gait);
    for (int i = 0; i + 1 < n; ++i)
        chain.theta[i + 1] = chain.theta[i] + table.joint(i, 0.0, 1.0).angle;
    chain.directions();
    chain.follow(shape.robot.l);
    std::vector<double> start;
    for (const auto* part : {&chain.x, &chain.y, &chain.theta})
        start.insert(start.end(), part->begin(), part->end());
    start.resize(6 * n);
    return start;
}

}  // namespace
}  // namespace serpenoid

using namespace serpenoid;

extern "C" {

// The speed of joints that follow the gait exactly, and its error, both within rtol of it if it
// returns 1.
int serpenoid_ideal(const double* scene, double rtol, double* speed_and_error) {
    try {
        const SteadyState state = steady_state(shape_of(scene), {rtol, false});
        speed_and_error[0] = state.speed;
        speed_and_error[1] = state.speed_error;
        return state.converged ? 1 : 0;
    } catch (const std::exception&) {
        return 0;
    }
}

// The speed with each of `count` servos, by time steps of at most `longest` s; `rough`: 1 or 2 %
// off in a quarter of the time. NaN where the robot settles to no speed.
int serpenoid_servos(const double* scene, const double* servos, int count, double longest,
                     int rough, double* speeds) {
    try {
        const SweepShape shape = shape_of(scene);
        const SteadyState ideal = steady_state(shape, {1e-6, false});
        int fields = 0;
        each_servo_field([&](const char*, double Servo::*) { ++fields; });
        for (int k = 0; k < count; ++k) {
            const ServoGaitState state =
                servo_gait(shape.robot, shape.ground, shape.gait, servo_of(servos + k * fields),
                           ideal.start, ideal.monodromy, longest, rough != 0);
            speeds[k] = state.converged || rough ? state.speed : NAN;
        }
        return 1;
    } catch (const std::exception&) {
        return 0;
    }
}

// The last of `cycles` cycles that begin at rest, with servos, frames + 1 times: for each link x,
// y, theta, and its speed across.
int serpenoid_motion(const double* scene, const double* servo, int cycles, int frames,
                     double* rows) {
    try {
        const SweepShape shape = shape_of(scene);
        RunRequest request;
        request.robot = shape.robot;
        request.ground = shape.ground;
        request.gait = shape.gait;
        request.drive = Drive::servo;
        request.servo = servo_of(servo);
        request.method = method_kind("nonsmooth");
        request.tolerance = 1e-3;  // less than a pixel of what is drawn
        request.duration = cycles * 2 * std::numbers::pi / shape.gait.omega;
        request.steps = static_cast<long long>(cycles) * frames;
        request.dt = request.duration / static_cast<double>(request.steps);
        request.max_steps = 100000;  // more would take minutes
        request.start = resting_start(shape);
        const RunResult run = simulate(request);
        if (run.failed_at >= 0) return 0;
        const std::size_t last = static_cast<std::size_t>(frames + 1) * shape.robot.n;
        for (std::size_t j = run.x.size() - last; j < run.x.size(); ++j) {
            const double across =
                std::cos(run.theta[j]) * run.vy[j] - std::sin(run.theta[j]) * run.vx[j];
            for (const double value : {run.x[j], run.y[j], run.theta[j], across}) *rows++ = value;
        }
        return 1;
    } catch (const std::exception&) {
        return 0;
    }
}

}  // extern "C"
