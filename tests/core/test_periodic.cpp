// Periodic states against figures of an independent spectral solver and of runs in time.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "cases.hpp"
#include "periodic/pieces/sliding_cycle.hpp"
#include "periodic/refinement.hpp"
#include "periodic/sweep.hpp"

using namespace serpenoid;
using doctest::Approx;

namespace {

const SweepShape kPaper{
    uniform_rod(6, 1.0, 0.12), {{0.1, 0}, {10.0, 0}}, {30 * kDegree, 80 * kDegree, 5.0, 0.0}};
const SweepShape kDry{uniform_rod(6, 0.0756, 0.076),
                      {{0.0132, 0.0325}, {0.37, 0.12}},
                      {70 * kDegree, 75 * kDegree, 5.0, 0.0}};

// Its cycles break off in axes that turn.
struct Unturned : SlidingCycle {
    using SlidingCycle::SlidingCycle;
    std::optional<CycleEnd> follow(const Vec3& p, const Following& how) override {
        return how.spin == 0 ? SlidingCycle::follow(p, how) : std::nullopt;
    }
};

}  // namespace

TEST_CASE("the paper's robot: speed and three powers") {
    const SteadyState state = steady_state(kPaper, {1e-9, true});
    REQUIRE(state.converged);
    CHECK(state.speed == Approx(0.292060796024).epsilon(1e-9));
    CHECK(state.power == Approx(0.073312554830).epsilon(1e-8));
    CHECK(state.abs_power == Approx(0.5146735).epsilon(1e-6));
    CHECK(state.positive_power == Approx(0.2939930).epsilon(1e-6));
}

TEST_CASE("a stated error covers the difference to a finer state, smooth and dry") {
    for (const SweepShape& shape : {kPaper, kDry}) {
        const SteadyState fine = steady_state(shape, {1e-8, true});
        for (const double tolerance : {1e-2, 1e-4}) {
            const SteadyState state = steady_state(shape, {tolerance, true});
            REQUIRE(state.converged);
            CHECK(state.speed_error <= tolerance);
            CHECK(std::fabs(state.speed - fine.speed) <=
                  1.05 * (state.speed_error + fine.speed_error) * fine.speed);
        }
    }
}

// The state is one of the motion: a run that begins in it comes back to it after a cycle.
TEST_CASE("a run from a periodic state repeats it on dry ground") {
    const SteadyState state = steady_state(kDry, {1e-7, false});
    REQUIRE(state.converged);
    const double period = 2 * std::numbers::pi / kDry.gait.omega;
    RunRequest request = request_of(kDry.robot, kDry.ground, kDry.gait, "nonsmooth", 6 * period);
    request.dt = period;
    request.steps = 6;
    request.tolerance = 1e-9;
    const RunResult run = simulate(request);
    REQUIRE(run.failed_at < 0);
    // from rest its transient is gone after five cycles: the chord of the last one is the speed
    const int n = kDry.robot.n;
    double dx = 0;
    double dy = 0;
    for (int link = 0; link < n; ++link) {
        dx += (run.x[6 * n + link] - run.x[5 * n + link]) / n;
        dy += (run.y[6 * n + link] - run.y[5 * n + link]) / n;
    }
    CHECK(std::hypot(dx, dy) / period == Approx(state.speed).epsilon(1e-3));
}

TEST_CASE("neither threads nor other shapes change a bit of a sweep") {
    const std::vector<SweepShape> shapes{kPaper, kDry, kPaper, kDry};
    const std::vector<double> omegas{2.0, 5.0};
    const auto keep_running = [](long) { return true; };
    std::vector<double> serial(shapes.size() * omegas.size() * kSweepColumns);
    std::vector<double> parallel(serial.size());
    sweep_shapes(shapes, omegas, {1e-4, true}, 1, keep_running, serial.data());
    sweep_shapes(shapes, omegas, {1e-4, true}, 2, keep_running, parallel.data());
    CHECK(serial == parallel);
    const std::size_t shape = omegas.size() * kSweepColumns;
    CHECK(serial[0] == serial[2 * shape]);
}

TEST_CASE("a gait that turns has no state where the cycle that tells its speed breaks off") {
    const Gait gait{70 * kDegree, 75 * kDegree, 5.0, 0.1};
    const SteadyOptions options{1e-4, false};
    const auto refined = [&](CycleMap& map) {
        FixedPoint point(map, false);
        REQUIRE(point.follow_cycles(10, 1e-3, 1e-4));
        const Acceptance accepted(options, kDry.robot, kDry.ground, gait.omega);
        return Refinement(map, point, options).refine(1e-4, accepted);
    };
    SlidingCycle whole(kDry.robot, kDry.ground, gait, 10'000);
    Unturned broken(kDry.robot, kDry.ground, gait, 10'000);
    CHECK(refined(whole).converged);
    CHECK_FALSE(refined(broken).converged);
}
