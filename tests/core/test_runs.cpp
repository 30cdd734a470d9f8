// Runs in time: imposed angles, events of sticking wheels, stiff springs.
#include <doctest/doctest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "cases.hpp"

using namespace serpenoid;
using doctest::Approx;

namespace {

const Robot kPaperRobot = uniform_rod(6, 1.0, 0.12);
const Ground kPaperGround{{0.1, 0}, {10.0, 0}};
const Gait kPaperGait{30 * kDegree, 80 * kDegree, 5.0, 0.0};

double sum(const std::vector<double>& values, std::size_t begin) {
    return std::accumulate(values.begin() + begin, values.end(), 0.0);
}

}  // namespace

// By Lagrange's equations of three links, integrated with 30 digits.
TEST_CASE("three links after ten seconds, by every method for smooth motion") {
    const Robot robot = uniform_rod(3, 1.0, 0.12);
    const Gait gait{30 * kDegree, 90 * kDegree, 3.0, 0.0};
    for (const char* method : {"rk4", "dop853", "nonsmooth"}) {
        CAPTURE(method);
        RunRequest request = request_of(robot, kPaperGround, gait, method, 10.0);
        request.tolerance = 1e-10;
        request.dt = 1e-3;
        request.steps = 10000;
        request.record_steps = 10000;
        const RunResult run = simulate(request);
        REQUIRE(run.failed_at < 0);
        CHECK(run.x[3] == Approx(0.6944674004).epsilon(1e-8));
        CHECK(run.y[3] == Approx(0.2002216975).epsilon(1e-8));
        CHECK(run.theta[3] == Approx(0.6090597074).epsilon(1e-8));
        CHECK(run.omega[3] == Approx(-0.7831627707).epsilon(1e-8));
    }
}

TEST_CASE("a straight robot slides to rest by dry friction, and stays") {
    const Robot robot = uniform_rod(4, 0.1, 0.1);
    constexpr double kFriction = 0.02, kSpeed = 0.3;  // N a link, m/s
    const double deceleration = kFriction / robot.m;
    RunRequest request =
        request_of(robot, {{0, kFriction}, {0, 0.1}}, {0, 0, 1.0, 0}, "nonsmooth", 4.0);
    for (int link = 0; link < robot.n; ++link) request.start[3 * robot.n + link] = kSpeed;
    request.dt = 0.5;
    request.steps = 8;
    const RunResult run = simulate(request);
    REQUIRE(run.failed_at < 0);
    CHECK(run.vx[2 * robot.n] == Approx(kSpeed - deceleration * 1.0).epsilon(1e-9));
    CHECK(run.x[8 * robot.n] == Approx(kSpeed * kSpeed / (2 * deceleration)).epsilon(1e-6));
    CHECK(std::fabs(run.vx[8 * robot.n]) < 1e-9);
}

TEST_CASE("on a slope wheels rest as long as their friction carries the weight") {
    const Robot robot = uniform_rod(4, 0.1, 0.1);
    const double pull = 0.2;  // m/s^2 along the robot
    for (const double share : {0.9, 1.1}) {
        CAPTURE(share);
        const double friction = robot.m * pull / share;
        RunRequest request =
            request_of(robot, {{0, friction}, {0, 1.0}}, {0, 0, 1.0, 0}, "nonsmooth", 2.0);
        request.slope.gx = pull;
        const RunResult run = simulate(request);
        REQUIRE(run.failed_at < 0);
        const double speed = share < 1 ? 0 : 2.0 * (pull - friction / robot.m);
        CHECK(std::fabs(run.vx[robot.n] - speed) < 1e-9);
    }
}

TEST_CASE("Radau meets its tolerance on springs, soft and stiff, with angles and servos") {
    struct Case {
        double stiffness, damping, duration;
        Drive drive;
    };
    for (const Case& c : {Case{1e3, 1, 0.3, Drive::angle}, Case{1e5, 10, 0.1, Drive::angle},
                          Case{1e5, 100, 0.05, Drive::servo}}) {
        CAPTURE(c.stiffness);
        RunRequest request =
            request_of(kPaperRobot, kPaperGround, kPaperGait, "dop853", c.duration);
        request.formulation = Formulation::implicit;
        request.drive = c.drive;
        request.servo.stiffness = 2.0;
        request.servo.torque_limit = 1.5;
        request.servo.speed_limit = 6.0;
        request.servo.damping = 0.02;
        request.spring = {c.stiffness, c.damping};
        request.tolerance = 1e-12;
        const RunResult exact = simulate(request);
        REQUIRE(exact.failed_at < 0);
        request.method = method_kind("radau");
        for (const double tolerance : {1e-4, 1e-7}) {
            request.tolerance = tolerance;
            const RunResult run = simulate(request);
            REQUIRE(run.failed_at < 0);
            const double body = 2 * kPaperRobot.l * kPaperRobot.n;
            for (int link = kPaperRobot.n; link < 2 * kPaperRobot.n; ++link) {
                CHECK(std::fabs(run.x[link] - exact.x[link]) < tolerance * body);
                CHECK(std::fabs(run.theta[link] - exact.theta[link]) < tolerance);
            }
        }
    }
}

TEST_CASE("stiff springs come to the pinned motion, with an error like 1/k") {
    RunRequest request = request_of(kPaperRobot, kPaperGround, kPaperGait, "dop853", 1.0);
    request.tolerance = 1e-10;
    const RunResult pinned = simulate(request);
    request.formulation = Formulation::implicit;
    request.method = method_kind("radau");
    double earlier = 0;
    for (const double stiffness : {1e6, 1e8}) {
        request.spring = {stiffness, 1e-3 * stiffness};
        const RunResult run = simulate(request);
        REQUIRE(run.failed_at < 0);
        const double off = std::fabs(run.theta.back() - pinned.theta.back());
        if (earlier > 0) CHECK(off < 0.03 * earlier);
        earlier = off;
    }
    CHECK(earlier > 0);
}

TEST_CASE("on springs nothing but the ground changes the momentum") {
    for (const char* method : {"rk4", "dop853", "radau", "nonsmooth"}) {
        CAPTURE(method);
        RunRequest request = request_of(kPaperRobot, {{0, 0}, {0, 0}}, kPaperGait, method, 1.0);
        request.formulation = Formulation::implicit;
        request.dt = 1e-3;
        request.steps = 1000;
        request.record_steps = 1000;
        const std::size_t n = kPaperRobot.n;
        const double before =
            std::accumulate(request.start.begin() + 4 * n, request.start.begin() + 5 * n, 0.0);
        const RunResult run = simulate(request);
        REQUIRE(run.failed_at < 0);
        CHECK(sum(run.vy, n) == Approx(before).epsilon(1e-11));
    }
}

TEST_CASE("an end does not depend on what is recorded") {
    for (const char* method : {"rk4", "radau"}) {
        CAPTURE(method);
        RunRequest request = request_of(kPaperRobot, kPaperGround, kPaperGait, method, 0.5);
        request.formulation = Formulation::implicit;
        request.dt = 1e-3;
        request.steps = 500;
        request.record_steps = 500;
        const RunResult plain = simulate(request);
        request.record_energy = true;
        request.record_joints = true;
        request.record_steps = 100;
        const RunResult full = simulate(request);
        CHECK(full.theta.back() == plain.theta.back());
        CHECK(full.x.back() == plain.x.back());
    }
}
