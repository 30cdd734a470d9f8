// Motion of the whole chain in the body frame, and the mechanical power of each joint.
#pragma once

#include "body/body_shape.hpp"
#include "model/joint_sums.hpp"
#include "model/params.hpp"

namespace serpenoid {

// The state of motion at one instant, body frame: see body_shape.hpp. Rates are by time.
struct BodyMotion {
    double u[3];     // Vx, Vy (m/s), w (rad/s)
    double udot[3];  // derivatives of these components

    // From u and the total friction force and couple: nm(V' + w x V) = F, (J w + omega K)' = M.
    static BodyMotion from_forces(const Robot& r, const BodyShape& s, double omega,
                                  const double u[3], const double force[3]) {
        const double nm = r.n * r.m, w = u[2];
        return {{u[0], u[1], w},
                {force[0] / nm + w * u[1], force[1] / nm - w * u[0],
                 (force[2] - omega * omega * s.K1 - omega * s.J1 * w) / s.J}};
    }
};

// Call each(i, T_i, phi_i') for joints i = 0..n-2, N m and rad/s; P_i = -T_i phi_i'. Given is the
// friction on every link along and across it: friction(i) returns {f_t, f_n}. The shape needs
// second derivatives.
template <class Friction, class Each>
void joint_powers(const Robot& r, const BodyShape& s, double omega, const BodyMotion& b,
                  Friction friction, Each each) {
    const double w = b.u[2], wdot = b.udot[2], ww = w * w, cross = 2 * w * omega,
                 oo = omega * omega;
    const double Ax = b.udot[0] - w * b.u[1], Ay = b.udot[1] + w * b.u[0];
    JointSums sums;
    for (int i = 0; i + 1 < r.n; ++i) {
        const LinkShape& k = s.link[i];
        const double ax = Ax - wdot * k.ry - ww * k.rx - cross * k.ry1 + oo * k.rx2;
        const double ay = Ay + wdot * k.rx - ww * k.ry + cross * k.rx1 + oo * k.ry2;
        const auto [ft, fn] = friction(i);
        sums.add(r, k.n.x, k.n.y, ax, ay, wdot + oo * k.s2, ft * k.t.x + fn * k.n.x,
                 ft * k.t.y + fn * k.n.y);
        each(i, sums.T, omega * (s.link[i + 1].s1 - k.s1));
    }
}

}  // namespace serpenoid
