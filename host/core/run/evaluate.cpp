// One evaluation of either formulation, on plain ground.
#include "run/evaluate.hpp"

#include "model/explicit_model.hpp"
#include "model/ground_force.hpp"

namespace serpenoid {

void evaluate(const RunRequest& q, const double* joint_acceleration, Chain& chain, Joints& joints) {
    chain.directions();
    if (q.smoothing > 0)
        GroundForce<SmoothedRatchet, Flat>(q.ground, q.smoothing, {}, 0)(chain);
    else
        GroundForce<Ratchet, Flat>(q.ground, 0, {}, 0)(chain);
    const bool angle = q.drive == Drive::angle;
    if (q.formulation == Formulation::explicit_) {
        chain.follow(q.robot.l);
        angle ? explicit_angle(q.robot, joint_acceleration, chain, joints)
              : explicit_torque(q.robot, chain, joints);
    } else {
        spring_forces(q.robot, q.spring, Damper(q.robot.n, false), chain, joints);
        angle ? implicit_angle(q.robot, joint_acceleration, chain, joints)
              : implicit_torque(q.robot, chain, joints);
    }
}

}  // namespace serpenoid
