// Joint forces and torques of the explicit model, recovered link by link from the tail.
//
// With a_j the acceleration of link j and f_j the friction on it,
//     F_i = sum_{j<=i} (m a_j - f_j),    T_i = sum_{j<=i} [I theta_j'' - l n_j x (F_j + F_{j-1})]
// (Eqs. 1-9 summed); both vanish behind the head, which checks the motion.
#pragma once

#include "model/params.hpp"

namespace serpenoid {

// Running sums over the links; the value after link i is the force and torque of joint i.
struct JointSums {
    double Fx = 0, Fy = 0, T = 0;  // on link i from link i+1

    // Add a link: normal (nx, ny), acceleration (ax, ay), angular acceleration, friction (fx, fy).
    void add(const Robot& r, double nx, double ny, double ax, double ay, double angular, double fx,
             double fy) {
        const double Gx = Fx + r.m * ax - fx, Gy = Fy + r.m * ay - fy;
        T += r.I * angular - r.l * (nx * (Fx + Gx) + ny * (Fy + Gy));
        Fx = Gx, Fy = Gy;
    }
};

}  // namespace serpenoid
