// The parts of a scene's system, and how its rates come from them.
#include "scene/system.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

std::unique_ptr<TorqueSource> make_torques(const RunRequest& request, double gear_friction) {
    if (request.drive == Drive::servo) {
        Servo servo = request.servo;
        servo.gear_friction = gear_friction;
        return std::make_unique<ServoTorque>(servo, request.gait, request.robot.n);
    }
    if (request.drive == Drive::torque && request.table.empty())
        return std::make_unique<FunctionTorque>(request.torque);
    const TorqueRows none{{0}, std::vector<double>(request.robot.n - 1)};
    return std::make_unique<TableTorque>(request.drive == Drive::torque ? request.table : none);
}

System::System(const RunRequest& request) {
    if (request.record_energy) ledger_.emplace(request);
    if (request.formulation == Formulation::implicit) {
        // A method that computes the friction itself needs a system without friction.
        const Ground ground = request.method.computes_friction ? Ground{} : request.ground;
        mechanics_ = make_implicit(request, ground, gear_friction(request));
    } else if (request.method.computes_friction) {
        const Ground smooth{{request.ground.along.viscous(0), 0}, {request.ground.across.c, 0}};
        mechanics_ = make_explicit(request, smooth, 0);
        sticking_ = std::make_unique<Sticking>(*mechanics_, request);
    } else {
        mechanics_ = make_explicit(request, request.ground, gear_friction(request));
    }
}

void System::write_state(const Chain& source, double* y) const {
    mechanics_->write_state(source, y);
    std::fill(y + 2 * coordinates(), y + dim(), 0.0);
}

void System::forces(double t, const double* y) {
    if (sticking_)
        sticking_->forces(t, y);
    else
        mechanics_->forces(t, y);
}

void System::rate_with_parts(double t, const double* y, double* dy) {
    if (sticking_) {
        sticking_->forces(t, y);
        mechanics_->derivative(y, dy);
    } else {
        mechanics_->rate(t, y, dy);
        if (!mechanics_->rate_fills_forces()) mechanics_->forces(t, y);
    }
    if (ledger_) ledger_->rates(*mechanics_, dy + 2 * coordinates());
}

void System::powers(double t, const double* y, std::vector<double>& power) {
    forces(t, y);
    for (std::size_t i = 0; i < power.size(); ++i) power[i] = joint_power(*mechanics_, i);
}

std::vector<double> error_scale(const System& system, const RunRequest& request) {
    const int m = system.coordinates();
    const double body = 2 * request.robot.l * request.robot.n;
    std::vector<double> scale(system.dim(), HUGE_VAL);
    for (int i = 0; i < m; ++i) {
        scale[i] = i < system.lengths() ? body : 1;
        scale[m + i] = scale[i] * rate_unit(request);
    }
    return scale;
}

}  // namespace serpenoid
