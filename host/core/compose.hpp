// From what a scene has to the one system that is compiled with exactly that.
#pragma once

#include <memory>

#include "ground_force.hpp"
#include "method.hpp"
#include "run_request.hpp"
#include "system.hpp"

namespace serpenoid {

std::unique_ptr<System> compose_explicit(const RunRequest& request);
std::unique_ptr<System> compose_implicit(const RunRequest& request);
std::unique_ptr<System> compose(const RunRequest& request);
std::unique_ptr<Method> make_method(const RunRequest& request, System& system);

// Call make.template operator()<Force>() with the ground force that a request asks for.
template <class Make>
std::unique_ptr<System> with_force(const RunRequest& q, const Make& make) {
    const auto plane = [&]<class Law>() {
        return q.slope.tilted() ? make.template operator()<GroundForce<Law, Tilted>>()
                                : make.template operator()<GroundForce<Law, Flat>>();
    };
    if (q.ground.dry() && q.smoothing > 0) return plane.template operator()<Smoothed>();
    if (q.ground.dry() && q.ground.viscous()) return plane.template operator()<Bingham>();
    if (q.ground.dry()) return plane.template operator()<Coulomb>();
    return q.ground.viscous() ? plane.template operator()<Viscous>()
                              : plane.template operator()<Frictionless>();
}

inline bool mixed(const RunRequest& q) { return !q.faults.empty(); }

inline MixedDrive mixed_drive(const RunRequest& q) {
    return {q.robot.n, q.gait, q.drive == Drive::angle, q.faults, q.locked_rad};
}

std::unique_ptr<TorqueSource> torque_source(const RunRequest& request);

}  // namespace serpenoid
