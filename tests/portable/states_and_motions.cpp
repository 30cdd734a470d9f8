// Prints 30 periodic states and one period of motion from each, one line for each, all digits.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "model/chain.hpp"
#include "periodic/sweep.hpp"
#include "run/simulation.hpp"

using namespace serpenoid;

namespace {

constexpr int kFrames = 20, kMostLinks = 8;
constexpr double kStateRtol = 1e-6, kStartRtol = 1e-5, kMotionTolerance = 1e-6;

void print(int answer, const std::vector<double>& values) {
    std::printf("%d", answer);
    for (const double value : values) std::printf(" %.17g", value);
    std::printf("\n");
}

double mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

// Link 1 at the origin along x, moving as given; the joints as the gait has them at t = 0.
Chain placed(const SweepShape& shape, double vx, double vy, double turn_rate) {
    Chain chain(shape.robot.n);
    const GaitTable table(shape.robot.n, shape.gait);
    chain.vx[0] = vx;
    chain.vy[0] = vy;
    chain.omega[0] = turn_rate;
    for (int i = 0; i + 1 < shape.robot.n; ++i) {
        const GaitTable::Joint joint = table.at(i, 0.0, 1.0);
        chain.theta[i + 1] = chain.theta[i] + joint.angle;
        chain.omega[i + 1] = chain.omega[i] + shape.gait.omega * joint.slope;
    }
    chain.directions();
    chain.follow(shape.robot.l);
    return chain;
}

// The links at phase 0 of the periodic state, whose velocities are those of the centre of mass.
std::vector<double> periodic_start(const SweepShape& shape, const Vec3& velocity) {
    const Chain rest = placed(shape, 0, 0, 0);
    const double dx = rest.x[0] - mean(rest.x), dy = rest.y[0] - mean(rest.y);
    const Chain chain = placed(shape, velocity[0] - velocity[2] * dy - mean(rest.vx),
                               velocity[1] + velocity[2] * dx - mean(rest.vy), velocity[2]);
    std::vector<double> start;
    for (const auto* part : {&chain.x, &chain.y, &chain.theta, &chain.vx, &chain.vy, &chain.omega})
        start.insert(start.end(), part->begin(), part->end());
    return start;
}

void print_motion(const SweepShape& shape) {
    RunRequest request;
    request.robot = shape.robot;
    request.ground = shape.ground;
    request.gait = shape.gait;
    request.method = method_kind(shape.ground.smooth() ? "dop853" : "nonsmooth");
    request.duration = 2 * std::numbers::pi / shape.gait.omega;
    request.dt = request.duration / kFrames;
    request.steps = kFrames;
    request.most_steps = 100000;
    request.tolerance = kMotionTolerance;
    request.record_joints = true;
    request.start = periodic_start(shape, steady_state(shape, {kStartRtol, false}).start);
    const RunResult run = simulate(request);
    std::vector<double> values;
    for (const auto* part : {&run.x, &run.y, &run.theta, &run.vx, &run.vy, &run.joint_torque})
        values.insert(values.end(), part->begin(), part->end());
    print(run.failed_at < 0 ? static_cast<int>(run.t.size()) : 0, values);
}

}  // namespace

int main() {
    for (int k = 0; k < 30; ++k) {
        const auto between = [k](double low, double high, double stride) {
            return low + (high - low) * std::fmod(k * stride, 1.0);
        };
        const int links = 3 + k % (kMostLinks - 2);
        const double mass = between(0.02, 1, 0.618), length = between(0.04, 0.2, 0.755);
        const double ct = between(0.01, 0.1, 0.57), cn = between(0.2, 2, 0.82);
        // every other one on dry ground, some with a ratchet, some that turn
        const double ft0 = k % 2 * between(0.005, 0.03, 0.67);
        const double fn0 = k % 2 * between(0.03, 0.1, 0.55);
        const double back = k % 5 == 3 ? 3 : 1, offset = k % 7 == 6 ? 0.1 : 0;
        const SweepShape shape = {
            {links, mass, length / 2, mass * length * length / 12},
            {ct, cn, ft0, fn0, ct * back, ft0 * back},
            {between(0.3, 1.3, 0.45), between(0.5, 1.5, 0.38), between(1, 6, 0.22), offset}};
        const SteadyState state = steady_state(shape, {kStateRtol, true});
        print(state.converged ? 1 : 0,
              {state.speed, state.power, state.abs_power, state.positive_power, state.turn});
        print_motion(shape);
    }
}
