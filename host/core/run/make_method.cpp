// The table of methods, and what adaptive ones weigh errors by.
#include "run/make_method.hpp"

#include <algorithm>
#include <stdexcept>

#include "methods/adaptive/collocation.hpp"
#include "methods/adaptive/dop853.hpp"
#include "methods/adaptive/error_scale.hpp"
#include "methods/euler.hpp"
#include "methods/paper_scheme.hpp"
#include "methods/rk4.hpp"
#include "methods/rk4_vector.hpp"
#include "methods/semi_implicit_euler.hpp"
#include "methods/set_valued_motion.hpp"
#include "methods/stick_slip.hpp"
#include "methods/stiff/radau.hpp"

namespace serpenoid {

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
