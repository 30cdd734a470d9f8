// Every explicit system that a scene may ask for, instantiated once.
#include "scene/explicit_systems.hpp"

#include "scene/make_system.hpp"
#include "scene/make_torques.hpp"
#include "scene/terms.hpp"

namespace serpenoid {

std::unique_ptr<PairedSystem> make_paired(const RunRequest& q) {
    return with_force<PairedSystem>(q, [&]<class Force>() -> std::unique_ptr<PairedSystem> {
        if (mixed(q))
            return std::make_unique<ExplicitMixed<Force>>(q, mixed_drive(q), make_torques(q));
        if (q.drive == Drive::angle) return std::make_unique<ExplicitAngle<Force>>(q);
        return std::make_unique<ExplicitTorque<Force>>(q, make_torques(q));
    });
}

std::unique_ptr<System> make_explicit(const RunRequest& q) { return make_paired(q); }

}  // namespace serpenoid
