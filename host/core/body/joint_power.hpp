// Motion of the whole chain in the body frame, and the mechanical power of each joint.
#pragma once

#include "body/body_shape.hpp"
#include "model/joint_sums.hpp"
#include "model/params.hpp"

namespace serpenoid {

// The state of motion at one instant, body frame: see body_shape.hpp. Rates are by time.
template <class Real>
struct BodyMotionOf {
    Real u[3];     // Vx, Vy (m/s), w (rad/s)
    Real udot[3];  // derivatives of these components

    // From u and the total friction force and couple: nm(V' + w x V) = F, (J w + omega K)' = M.
    static BodyMotionOf from_forces(const Robot& r, const BodyShapeOf<Real>& s, double omega,
                                    const Real u[3], const Real force[3]) {
        const double nm = r.n * r.m;
        const Real w = u[2];
        return {{u[0], u[1], w},
                {force[0] / nm + w * u[1], force[1] / nm - w * u[0],
                 (force[2] - omega * omega * s.K1 - omega * s.J1 * w) / s.J}};
    }
};
using BodyMotion = BodyMotionOf<double>;

// Call visit(i, T_i, phi_i') for joints i = 0..n-2, N m and rad/s; P_i = -T_i phi_i'. Given is the
// friction on every link along and across it: friction(i) returns {f_t, f_n}. The shape needs
// second derivatives.
template <class Real, class Friction, class Visit>
void joint_powers(const Robot& r, const BodyShapeOf<Real>& s, double omega,
                  const BodyMotionOf<Real>& b, Friction friction, Visit visit) {
    const double oo = omega * omega;
    const Real w = b.u[2], wdot = b.udot[2], ww = w * w, cross = 2.0 * omega * w;
    const Real Ax = b.udot[0] - w * b.u[1], Ay = b.udot[1] + w * b.u[0];
    JointSumsOf<Real> sums;
    for (int i = 0; i + 1 < r.n; ++i) {
        const LinkShapeOf<Real>& k = s.link[i];
        const Real ax = Ax - wdot * k.ry - ww * k.rx - cross * k.ry1 + oo * k.rx2;
        const Real ay = Ay + wdot * k.rx - ww * k.ry + cross * k.rx1 + oo * k.ry2;
        const auto [ft, fn] = friction(i);
        sums.add(r, k.n.x, k.n.y, ax, ay, wdot + oo * k.s2, ft * k.t.x + fn * k.n.x,
                 ft * k.t.y + fn * k.n.y);
        visit(i, sums.T, omega * (s.link[i + 1].s1 - k.s1));
    }
}

}  // namespace serpenoid
