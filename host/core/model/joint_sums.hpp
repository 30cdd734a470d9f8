// Joint forces and torques of the explicit model, recovered link by link from the tail.
//
// With a_j the acceleration of link j and f_j the friction on it,
//     F_i = sum_{j<=i} (m a_j - f_j),    T_i = sum_{j<=i} [I theta_j'' - l n_j x (F_j + F_{j-1})]
// (Eqs. 1-9 summed); both vanish behind the head, which checks the motion.
#pragma once

#include "model/params.hpp"

namespace serpenoid {

// Running sums over the links; the value after link i is the force and torque of joint i.
template <class Real>
struct JointSumsOf {
    Real Fx{}, Fy{}, T{};  // on link i from link i+1

    // Add a link: normal (nx, ny), acceleration (ax, ay), angular acceleration, friction (fx, fy).
    void add(const Robot& r, Real nx, Real ny, Real ax, Real ay, Real angular, Real fx, Real fy) {
        const Real Gx = Fx + r.m * ax - fx, Gy = Fy + r.m * ay - fy;
        T += r.I * angular - r.l * (nx * (Fx + Gx) + ny * (Fy + Gy));
        Fx = Gx, Fy = Gy;
    }
};
using JointSums = JointSumsOf<double>;

}  // namespace serpenoid
