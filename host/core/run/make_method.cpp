// Makes each method of the registry.
#include "run/make_method.hpp"

#include <vector>

#include "methods/adaptive/dop853.hpp"
#include "methods/adaptive/mode_steps.hpp"
#include "methods/adaptive/radau.hpp"
#include "methods/paper_scheme.hpp"
#include "methods/rk4.hpp"
#include "methods/stick_slip.hpp"

namespace serpenoid {

std::unique_ptr<Method> make_method(const RunRequest& q, System& system) {
    const auto is = [&q](const char* name) { return q.method.is(name); };
    if (is("rk4")) return std::make_unique<Rk4>(system, q.dt);
    if (is("paper")) return std::make_unique<PaperScheme>(system, q.dt);
    const std::vector<double> scale = error_scale(system, q);
    if (is("dop853")) return std::make_unique<Dop853>(system, scale, q.tolerance);
    if (is("radau")) return std::make_unique<Radau>(system, scale, q.tolerance);
    if (q.formulation == Formulation::implicit)
        return std::make_unique<StickSlip>(system, q.robot, q.ground, q.dt);
    return std::make_unique<ModeSteps>(system, *system.sticking(), scale, mode_tolerance(q),
                                       1e-12 / rate_unit(q));
}

}  // namespace serpenoid
