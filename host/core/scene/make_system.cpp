// Formulation first, then the terms (explicit_systems.cpp, implicit_systems.cpp).
#include "scene/make_system.hpp"

#include <algorithm>

#include "scene/sticking_system.hpp"

namespace serpenoid {

namespace {

// A system without dry friction, which the wrapper adds.
std::unique_ptr<System> make_sticking(const RunRequest& q) {
    constexpr double kAtRest = 1e-3;     // of a step's tolerance
    constexpr double kRounding = 1e-10;  // least tolerance: below it that speed is rounding
    RunRequest slippery = q;
    slippery.ground = {WheelLaw::along(q.ground).mean_viscous(), q.ground.cn, 0, 0};
    slippery.servo.gear_friction = 0;
    const double speed = 2 * q.robot.l * q.robot.n * rate_unit(q);
    const double moves = q.robot.n * q.robot.m * speed * rate_unit(q);
    return std::make_unique<StickingSystem>(
        make_paired(slippery), q, kAtRest * std::max(mode_tolerance(q), kRounding) * speed, moves);
}

}  // namespace

std::unique_ptr<TorqueSource> make_torques(const RunRequest& q) {
    if (q.drive == Drive::angle) return std::make_unique<NoTorque>();
    if (q.drive == Drive::servo) return std::make_unique<ServoTorque>(q.servo, q.gait, q.robot.n);
    if (!q.table.empty()) return std::make_unique<TableTorque>(q.table);
    return std::make_unique<FunctionTorque>(q.torque);
}

std::unique_ptr<System> make_system(const RunRequest& q) {
    const bool pinned = q.formulation == Formulation::explicit_;
    if (pinned && q.method.makes_friction) return make_sticking(q);
    if (pinned) return make_explicit(q);
    if (!q.method.makes_friction) return make_implicit(q);
    RunRequest bare = q;  // the method itself applies the friction
    bare.ground = {0, 0, 0, 0};
    return make_implicit(bare);
}

}  // namespace serpenoid
