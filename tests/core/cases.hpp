// Robots, first poses and requests of runs, shared by the tests of the core.
#pragma once

#include <vector>

#include "run/simulation.hpp"

namespace serpenoid {

inline Robot uniform_rod(int links, double mass, double length) {
    const double half = length / 2;
    return {links, mass, half, mass * half * half / 3};
}

constexpr double kDegree = 0.017453292519943295;

// x, y, theta, vx, vy, omega of a chain.
inline std::vector<double> packed(const Chain& chain) {
    std::vector<double> start;
    for (const auto* part : {&chain.x, &chain.y, &chain.theta, &chain.vx, &chain.vy, &chain.omega})
        start.insert(start.end(), part->begin(), part->end());
    return start;
}

// The chain of a gait at t = 0 with closed joints; link 1 is at rest at the origin, along x.
inline Chain first_pose(const Robot& robot, const Gait& gait) {
    Chain chain(robot.n);
    const GaitTable table(robot.n, gait);
    for (int i = 0; i + 1 < robot.n; ++i) {
        const GaitTable::Joint joint = table.joint(i, 0.0, 1.0);
        chain.theta[i + 1] = chain.theta[i] + joint.angle;
        chain.omega[i + 1] = chain.omega[i] + gait.omega * joint.slope;
    }
    chain.directions();
    chain.follow(robot.l);
    return chain;
}

// The request of a run that records only its end.
inline RunRequest request_of(const Robot& robot, const Ground& ground, const Gait& gait,
                             const char* method, double duration) {
    RunRequest request;
    request.robot = robot;
    request.ground = ground;
    request.gait = gait;
    request.method = method_kind(method);
    request.duration = duration;
    request.dt = duration;
    request.steps = 1;
    request.max_steps = 10'000'000;
    request.start = packed(first_pose(robot, gait));
    return request;
}

}  // namespace serpenoid
