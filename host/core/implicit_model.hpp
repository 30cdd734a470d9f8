// The paper's implicit model: links joined by a spring and a damper instead of a pin (Eqs. 51-56).
//
//     Delta_i = (c_{i+1} - l t_{i+1}) - (c_i + l t_i),   F_i = k Delta_i + c Delta_i',
//     m a_i = f_i + F_i - F_{i-1},
// torques imposed:  I theta_i'' = T_i - T_{i-1} + l n_i . (F_i + F_{i-1})
// angles imposed:   n I theta_1'' = sum l n_i . (F_i + F_{i-1}) - I sum s_i''.
#pragma once

#include "chain.hpp"

namespace serpenoid {

struct JointSpring {
    double k, c;  // N/m, N s/m
};

// Forces of all joints from the gaps between the links.
inline void spring_forces(const Robot& r, const JointSpring& spring, const Chain& k,
                          Joints& joints) {
    for (int i = 0; i + 1 < k.n(); ++i) {
        const double gx = k.x[i + 1] - k.x[i] - r.l * (k.c[i + 1] + k.c[i]);
        const double gy = k.y[i + 1] - k.y[i] - r.l * (k.s[i + 1] + k.s[i]);
        const double ux =
            k.vx[i + 1] - k.vx[i] + r.l * (k.omega[i + 1] * k.s[i + 1] + k.omega[i] * k.s[i]);
        const double uy =
            k.vy[i + 1] - k.vy[i] - r.l * (k.omega[i + 1] * k.c[i + 1] + k.omega[i] * k.c[i]);
        joints.Fx[i] = spring.k * gx + spring.c * ux;
        joints.Fy[i] = spring.k * gy + spring.c * uy;
    }
}

// l n_i . (F_i + F_{i-1}), the couple of the joint forces on link i; also fills a_i.
inline double link_balance(const Robot& r, Chain& k, const Joints& joints, int i) {
    const double px = i > 0 ? joints.Fx[i - 1] : 0, py = i > 0 ? joints.Fy[i - 1] : 0;
    const double qx = i + 1 < k.n() ? joints.Fx[i] : 0, qy = i + 1 < k.n() ? joints.Fy[i] : 0;
    k.ax[i] = (k.fx[i] + qx - px) / r.m;
    k.ay[i] = (k.fy[i] + qy - py) / r.m;
    return r.l * (-k.s[i] * (px + qx) + k.c[i] * (py + qy));
}

// Angles imposed: bend[j] = phi_j''. Torques follow from the angular equation of each link.
inline void implicit_angle(const Robot& r, const JointSpring& spring, const double* bend, Chain& k,
                           Joints& joints) {
    const int n = k.n();
    spring_forces(r, spring, k, joints);
    double turn = 0, turns = 0, couples = 0;
    for (int i = 0; i < n; ++i) {
        if (i > 0) turn += bend[i - 1];
        turns += turn;
        k.alpha[i] = link_balance(r, k, joints, i);  // the couple, for now
        couples += k.alpha[i];
    }
    const double first = (couples - r.I * turns) / (n * r.I);
    turn = 0;
    double T = 0;
    for (int i = 0; i < n; ++i) {
        if (i > 0) turn += bend[i - 1];
        const double couple = k.alpha[i];
        k.alpha[i] = first + turn;
        T += r.I * k.alpha[i] - couple;
        if (i + 1 < n) joints.T[i] = T;
    }
}

inline void implicit_torque(const Robot& r, const JointSpring& spring, Chain& k, Joints& joints) {
    spring_forces(r, spring, k, joints);
    for (int i = 0; i < k.n(); ++i) {
        const double T = (i + 1 < k.n() ? joints.T[i] : 0.0) - (i > 0 ? joints.T[i - 1] : 0.0);
        k.alpha[i] = (T + link_balance(r, k, joints, i)) / r.I;
    }
}

}  // namespace serpenoid
