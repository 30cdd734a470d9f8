// Makes each method of the registry, and the error scales of adaptive ones.
#include "run/make_method.hpp"

#include <algorithm>
#include <stdexcept>

#include "methods/adaptive/dop853.hpp"
#include "methods/adaptive/mode_steps.hpp"
#include "methods/adaptive/radau.hpp"
#include "methods/paper_scheme.hpp"
#include "methods/rk4.hpp"
#include "methods/stick_slip.hpp"

namespace serpenoid {

namespace {

std::vector<double> error_scale(const RunRequest& q, const System& system) {
    return error_scale(system, 2 * q.robot.l * q.robot.n, rate_unit(q));
}

std::unique_ptr<Method> smooth(const RunRequest& q, System& system) {
    return std::make_unique<Dop853>(system, error_scale(q, system), q.tolerance);
}

std::unique_ptr<Method> nonsmooth(const RunRequest& q, System& system) {
    if (q.formulation == Formulation::implicit)
        return std::make_unique<StickSlip>(system, q.robot, q.ground, q.dt);
    return std::make_unique<ModeSteps>(system, *system.sticking(), error_scale(q, system),
                                       mode_tolerance(q), 1e-12 / rate_unit(q));
}

}  // namespace

std::unique_ptr<Method> make_method(const RunRequest& q, System& system) {
    const auto is = [&q](const char* name) { return q.method.is(name); };
    if (is("rk4")) return std::make_unique<Rk4>(system, q.dt);
    if (is("paper")) return std::make_unique<PaperScheme>(system, q.dt);
    if (is("dop853")) return smooth(q, system);
    if (is("radau")) return std::make_unique<Radau>(system, error_scale(q, system), q.tolerance);
    if (is("nonsmooth")) return nonsmooth(q, system);
    throw std::logic_error("no maker");
}

}  // namespace serpenoid
