// Which terms a scene has: the ground force it asks for, and which joints are not imposed.
#pragma once

#include <memory>

#include "drive/joint_angles.hpp"
#include "model/ground_force.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

// Call make.template operator()<Force>() with the ground force that a request asks for.
template <class Made, class Make>
std::unique_ptr<Made> with_force(const RunRequest& q, const Make& make) {
    const auto plane = [&]<class Law>() {
        return q.slope.tilted() ? make.template operator()<GroundForce<Law, Tilted>>()
                                : make.template operator()<GroundForce<Law, Flat>>();
    };
    if (q.ground.ratchet()) return plane.template operator()<Ratchet>();
    if (q.ground.dry() && q.ground.viscous()) return plane.template operator()<Bingham>();
    if (q.ground.dry()) return plane.template operator()<Coulomb>();
    return q.ground.viscous() ? plane.template operator()<Viscous>()
                              : plane.template operator()<Frictionless>();
}

// The same force behind a virtual call, for systems that are compiled once.
inline std::unique_ptr<ChainForce> make_force(const RunRequest& q) {
    return with_force<ChainForce>(q, [&]<class Force>() -> std::unique_ptr<ChainForce> {
        return std::make_unique<Force>(q.ground, q.slope, q.robot.m);
    });
}

// Whether any joint is not imposed: driven by a torque, limp or locked.
inline bool mixed(const RunRequest& q) { return q.drive != Drive::angle || !q.faults.empty(); }

inline MixedDrive mixed_drive(const RunRequest& q) {
    return {q.robot.n, q.gait, q.drive == Drive::angle, q.faults, q.locked_rad, armature(q)};
}

}  // namespace serpenoid
