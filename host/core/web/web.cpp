// The core for a page in a browser: the periodic state of a gait, and its motion, in plain numbers.
//
// All arrays are doubles in SI units and radians. `ask` has, in this order: links, mass of a link,
// its length, its inertia; ct, cn, ft0, fn0 of a link, ct and ft0 backwards; alpha, beta, omega,
// offset. The caller has checked the ranges.
#include <algorithm>
#include <cmath>
#include <exception>
#include <numbers>

#include "model/chain.hpp"
#include "model/gait.hpp"
#include "periodic/sweep.hpp"
#include "run/simulation.hpp"
#include "servos/servo_gait.hpp"

namespace serpenoid {
namespace {

constexpr double kMotionRtol = 1e-5, kMotionTolerance = 1e-6, kServoRtol = 1e-6;

SweepShape shape_of(const double* a) {
    return {{static_cast<int>(a[0]), a[1], a[2] / 2, a[3]},
            {a[4], a[5], a[6], a[7], a[8], a[9]},
            {a[10], a[11], a[12], a[13]}};
}

double mean(const std::vector<double>& of) {
    double sum = 0;
    for (const double v : of) sum += v;
    return sum / static_cast<double>(of.size());
}

// Link 1 at the origin along x, moving as given; the joints as the gait has them at t = 0.
Chain placed(const SweepShape& s, double vx, double vy, double turn) {
    Chain c(s.robot.n);
    const GaitTable table(s.robot.n, s.gait);
    c.vx[0] = vx, c.vy[0] = vy, c.omega[0] = turn;
    for (int i = 0; i + 1 < s.robot.n; ++i) {
        const GaitTable::Joint joint = table.at(i, 0.0, 1.0);
        c.theta[i + 1] = c.theta[i] + joint.angle;
        c.omega[i + 1] = c.omega[i] + s.gait.omega * joint.slope;
    }
    c.directions();
    c.follow(s.robot.l);
    return c;
}

// The links at phase 0 of the periodic state, whose velocities are those of the centre of mass.
std::vector<double> periodic_start(const SweepShape& s, const Vec3& u) {
    const Chain rest = placed(s, 0, 0, 0);
    const double dx = rest.x[0] - mean(rest.x), dy = rest.y[0] - mean(rest.y);
    const Chain c =
        placed(s, u[0] - u[2] * dy - mean(rest.vx), u[1] + u[2] * dx - mean(rest.vy), u[2]);
    std::vector<double> start;
    for (const auto* part : {&c.x, &c.y, &c.theta, &c.vx, &c.vy, &c.omega})
        start.insert(start.end(), part->begin(), part->end());
    return start;
}

RunRequest one_period(const SweepShape& s, int frames) {
    RunRequest q;
    q.robot = s.robot, q.ground = s.ground, q.gait = s.gait;
    q.method = method_kind(s.ground.smooth() ? "dop853" : "nonsmooth");
    q.duration = 2 * std::numbers::pi / s.gait.omega;
    q.dt = q.duration / frames, q.steps = frames, q.most_steps = 100000;
    q.tolerance = kMotionTolerance;
    q.record_joints = true;
    return q;
}

}  // namespace
}  // namespace serpenoid

using namespace serpenoid;

extern "C" {

// Speed, power, mean |P|, mean P+, turn a cycle; then the error bounds of speed, power, P+ and
// turn. Returns 1 when they are within rtol, 0 when not, -1 when there is no answer.
int serpenoid_steady(const double* ask, double rtol, int powers, double* to) {
    try {
        const SteadyState s = steady_state(shape_of(ask), {rtol, powers != 0});
        const double values[] = {s.speed,     s.power,       s.abs_power,   s.positive_power,
                                 s.turn,      s.speed_error, s.power_error, s.positive_power_error,
                                 s.turn_error};
        std::copy(std::begin(values), std::end(values), to);
        return s.converged ? 1 : 0;
    } catch (const std::exception&) {
        return -1;
    }
}

// The same gait with a servo on every joint: mean speed, half its range over the phases of the
// board's frames, its error, amplitude over the gait's, lag. `servo`: the fields in the order of
// each_servo_field; steps of at most `longest` s. Returns as serpenoid_steady does.
int serpenoid_servo(const double* ask, const double* servo, double longest, double* to) {
    try {
        const SweepShape s = shape_of(ask);
        const SteadyState ideal = steady_state(s, {kServoRtol, false});
        Servo of;
        each_servo_field([&](const char*, double Servo::* field) { of.*field = *servo++; });
        const ServoGaitState found =
            servo_gait(s.robot, s.ground, s.gait, of, ideal.start, ideal.monodromy, longest);
        const double values[] = {found.speed, found.spread, found.error, found.amplitude,
                                 found.lag};
        std::copy(std::begin(values), std::end(values), to);
        return found.converged ? 1 : 0;
    } catch (const std::exception&) {
        return -1;
    }
}

// One period of the periodic state, frames + 1 times: for each link x, y, theta, its speed along
// and across; then, for each joint, the torque. Returns how many times there are, 0 for none.
int serpenoid_motion(const double* ask, int frames, double* to) {
    try {
        const SweepShape s = shape_of(ask);
        const SteadyState found = steady_state(s, {kMotionRtol, false});
        RunRequest q = one_period(s, frames);
        q.start = periodic_start(s, found.start);
        const RunResult run = simulate(q);
        if (run.failed_at >= 0) return 0;
        const int n = s.robot.n, times = static_cast<int>(run.t.size());
        for (int k = 0; k < times; ++k) {
            for (int j = k * n; j < (k + 1) * n; ++j) {
                const double c = std::cos(run.theta[j]), d = std::sin(run.theta[j]);
                *to++ = run.x[j], *to++ = run.y[j], *to++ = run.theta[j];
                *to++ = c * run.vx[j] + d * run.vy[j], *to++ = c * run.vy[j] - d * run.vx[j];
            }
            to = std::copy_n(&run.joint_torque[k * (n - 1)], n - 1, to);
        }
        return times;
    } catch (const std::exception&) {
        return 0;
    }
}

}  // extern "C"
