// Every explicit system that a scene may ask for, instantiated once.
#include "explicit_systems.hpp"

#include "compose.hpp"

namespace serpenoid {

std::unique_ptr<System> compose_explicit(const RunRequest& q) {
    return with_force(q, [&]<class Force>() -> std::unique_ptr<System> {
        if (mixed(q))
            return std::make_unique<ExplicitMixed<Force>>(q, mixed_drive(q), torque_source(q));
        if (q.drive == Drive::angle) return std::make_unique<ExplicitAngle<Force>>(q);
        return std::make_unique<ExplicitTorque<Force>>(q, torque_source(q));
    });
}

}  // namespace serpenoid
