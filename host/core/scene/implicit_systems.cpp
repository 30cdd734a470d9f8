// Every implicit system that a scene may ask for, instantiated once.
#include "scene/implicit_systems.hpp"

#include "scene/make_system.hpp"
#include "scene/make_torques.hpp"
#include "scene/terms.hpp"

namespace serpenoid {

template <class Damper>
static std::unique_ptr<System> with_damper(const RunRequest& q) {
    return with_force(q, [&]<class Force>() -> std::unique_ptr<System> {
        if (mixed(q))
            return std::make_unique<ImplicitMixed<Force, Damper>>(q, mixed_drive(q),
                                                                  make_torques(q));
        if (q.drive == Drive::angle) return std::make_unique<ImplicitAngle<Force, Damper>>(q);
        return std::make_unique<ImplicitTorque<Force, Damper>>(q, make_torques(q));
    });
}

std::unique_ptr<System> make_implicit(const RunRequest& q) {
    return q.method.holds_dampers ? with_damper<HeldDamper>(q) : with_damper<LiveDamper>(q);
}

}  // namespace serpenoid
