// Makes each method of the registry, and the error scales of adaptive ones.
#include "run/make_method.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string_view>

#include "methods/adaptive/collocation.hpp"
#include "methods/adaptive/dop853.hpp"
#include "methods/adaptive/error_scale.hpp"
#include "methods/adaptive/mode_steps.hpp"
#include "methods/paper_scheme.hpp"
#include "methods/rk4.hpp"
#include "methods/set_valued_motion.hpp"
#include "methods/stick_slip.hpp"
#include "methods/stiff/radau.hpp"
#include "model/friction_law.hpp"

namespace serpenoid {

namespace {

// Energies: kinetic energy of links that move by their length, and friction's work on them.
std::vector<double> error_scale(const RunRequest& q, const System& system) {
    const double rate = rate_unit(q);
    const double length = 2 * q.robot.l, speed = length * rate;
    const double friction = most_friction(q.ground, speed);
    const double energy = q.robot.n * (q.robot.m * speed * speed + friction * length);
    return error_scale(system, length * q.robot.n, rate, energy);
}

using Made = std::unique_ptr<Method>;

template <class OfFixedStep>
Made fixed(const RunRequest& q, System& system) {
    return std::make_unique<OfFixedStep>(system, q.dt);
}
Made dop853(const RunRequest& q, System& system) {
    return std::make_unique<Dop853>(system, error_scale(q, system), q.tolerance);
}
Made collocation(const RunRequest& q, System&) {
    return std::make_unique<Collocation>(q.robot, q.ground, q.gait, q.tolerance);
}
Made nonsmooth(const RunRequest& q, System& system) {
    if (q.formulation == Formulation::implicit)
        return std::make_unique<StickSlip>(system, q.robot, q.ground, q.dt);
    if (in_body_frame(q)) return std::make_unique<SetValuedMotion>(q);
    Modes* modes = system.modes();
    if (!modes) return dop853(q, system);
    return std::make_unique<ModeSteps>(system, *modes, error_scale(q, system), q.tolerance,
                                       1e-12 / rate_unit(q));
}

struct Maker {
    std::string_view name;
    Made (*make)(const RunRequest&, System&);
};
constexpr Maker kMakers[] = {
    {"rk4", fixed<Rk4>},          {"paper", fixed<PaperScheme>}, {"dop853", dop853},
    {"collocation", collocation}, {"radau", make_radau},         {"nonsmooth", nonsmooth},
};

constexpr bool every_method_has_its_maker() {
    if (std::size(kMakers) != std::size(kMethods)) return false;
    for (std::size_t i = 0; i < std::size(kMethods); ++i)
        if (!kMethods[i].is(kMakers[i].name)) return false;
    return true;
}
static_assert(every_method_has_its_maker());

}  // namespace

std::unique_ptr<Method> make_method(const RunRequest& q, System& system) {
    for (const Maker& maker : kMakers)
        if (q.method.is(maker.name)) return maker.make(q, system);
    throw std::logic_error("a method that is not in the table");
}

}  // namespace serpenoid
