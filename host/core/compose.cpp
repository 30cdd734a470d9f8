// The parts that a scene may have: formulation, drive, ground, method.
#include "compose.hpp"

#include <algorithm>
#include <stdexcept>

#include "collocation.hpp"
#include "dop853.hpp"
#include "error_scale.hpp"
#include "euler.hpp"
#include "paper_scheme.hpp"
#include "radau.hpp"
#include "rk4.hpp"
#include "rk4_lanes.hpp"
#include "semi_implicit_euler.hpp"
#include "set_valued_motion.hpp"
#include "stick_slip.hpp"

namespace serpenoid {

std::unique_ptr<TorqueSource> torque_source(const RunRequest& q) {
    if (q.drive == Drive::angle) return std::make_unique<NoTorque>();
    if (q.drive == Drive::servo) return std::make_unique<ServoTorque>(q.servo, q.gait, q.robot.n);
    if (!q.table.empty()) return std::make_unique<TableTorque>(q.table);
    return std::make_unique<FunctionTorque>(q.torque);
}

std::unique_ptr<System> compose(const RunRequest& q) {
    if (q.formulation == Formulation::explicit_) return compose_explicit(q);
    if (q.method != "nonsmooth") return compose_implicit(q);
    RunRequest bare = q;  // the method itself applies the friction
    bare.ground = {0, 0, 0, 0};
    return compose_implicit(bare);
}

namespace {

// A gait's motion has its rate as unit; other drives know no such time, and a second is theirs.
// Energies: of links that move by their length, and what friction takes from them, in that time.
std::vector<double> error_scale(const RunRequest& q, const System& system) {
    const double rate = q.drive == Drive::angle ? q.gait.omega : std::max(q.gait.omega, 1.0);
    const double length = 2 * q.robot.l, speed = length * rate;
    const Ground& g = q.ground;
    const double link = (q.robot.m + (g.ct + g.cn) / rate) * speed * speed;
    const double energy = q.robot.n * (link + (g.ft0 + g.fn0) * length);
    return error_scale(system, length * q.robot.n, rate, energy);
}

}  // namespace

std::unique_ptr<Method> make_method(const RunRequest& q, System& system) {
    if (Rk4Lanes::runs(q)) return std::make_unique<Rk4Lanes>(system, q);
    if (q.method == "rk4") return std::make_unique<Rk4>(system, q.dt);
    if (q.method == "euler") return std::make_unique<Euler>(system, q.dt);
    if (q.method == "semi_implicit_euler") return std::make_unique<SemiImplicitEuler>(system, q.dt);
    if (q.method == "paper") return std::make_unique<PaperScheme>(system, q.dt);
    if (q.method == "dop853")
        return std::make_unique<Dop853>(system, error_scale(q, system), q.tolerance);
    if (q.method == "collocation")
        return std::make_unique<Collocation>(q.robot, q.ground, q.gait, q.tolerance);
    if (q.method == "radau") return make_radau(q, system);
    if (q.method != "nonsmooth") throw std::invalid_argument("no such method: " + q.method);
    if (q.formulation == Formulation::implicit)
        return std::make_unique<StickSlip>(system, q.robot, q.ground, q.dt);
    return std::make_unique<SetValuedMotion>(q);
}

}  // namespace serpenoid
