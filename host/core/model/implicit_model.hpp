// The paper's implicit model: links joined by a spring and a damper instead of a pin (Eqs. 51-56).
//
//     Delta_i = (c_{i+1} - l t_{i+1}) - (c_i + l t_i),   F_i = k Delta_i + c Delta_i',
//     m a_i = f_i + F_i - F_{i-1},
// imposed torques:  I theta_i'' = T_i - T_{i-1} + l n_i . (F_i + F_{i-1})
// imposed angles:   n I theta_1'' = sum l n_i . (F_i + F_{i-1}) - I sum s_i''.
#pragma once

#include <vector>

#include "model/chain.hpp"

namespace serpenoid {

struct JointSpring {
    double k, c;  // N/m, N s/m
};

// Delta_i, m, and its rate, m/s.
inline Gap gap(const Chain& k, double l, int i) {
    return {k.x[i + 1] - k.x[i] - l * (k.c[i + 1] + k.c[i]),
            k.y[i + 1] - k.y[i] - l * (k.s[i + 1] + k.s[i]),
            k.vx[i + 1] - k.vx[i] + l * (k.omega[i + 1] * k.s[i + 1] + k.omega[i] * k.s[i]),
            k.vy[i + 1] - k.vy[i] - l * (k.omega[i + 1] * k.c[i + 1] + k.omega[i] * k.c[i])};
}

// The rates of the gaps on which the dampers act: the present ones or, in the paper's scheme, those
// stored by the last latch().
struct Damper {
    Damper(int links, bool latched) : latched(latched), vx(links - 1), vy(links - 1) {}
    void latch(const std::vector<Gap>& gaps) {
        for (std::size_t i = 0; i < gaps.size(); ++i) {
            vx[i] = gaps[i].vx;
            vy[i] = gaps[i].vy;
        }
    }
    bool latched;
    std::vector<double> vx, vy;
};

// Forces of all joints from the gaps between the links.
inline void spring_forces(const JointSpring& spring, const Damper& damper,
                          const std::vector<Gap>& gaps, Joints& joints) {
    for (std::size_t i = 0; i < gaps.size(); ++i) {
        const Gap& g = gaps[i];
        joints.Fx[i] = spring.k * g.x + spring.c * (damper.latched ? damper.vx[i] : g.vx);
        joints.Fy[i] = spring.k * g.y + spring.c * (damper.latched ? damper.vy[i] : g.vy);
    }
}

// Set a_i from the joint forces on link i, and return their moment, l n_i . (F_i + F_{i-1}).
inline double accelerate_link(const Robot& r, Chain& k, const Joints& joints, int i) {
    const double px = i > 0 ? joints.Fx[i - 1] : 0, py = i > 0 ? joints.Fy[i - 1] : 0;
    const double qx = i + 1 < k.n() ? joints.Fx[i] : 0, qy = i + 1 < k.n() ? joints.Fy[i] : 0;
    k.ax[i] = (k.fx[i] + qx - px) / r.m;
    k.ay[i] = (k.fy[i] + qy - py) / r.m;
    return r.l * (-k.s[i] * (px + qx) + k.c[i] * (py + qy));
}

// Fill the accelerations of a chain from the joint forces. Some joint angles are imposed, the
// others free, as in explicit_mixed. The torques of imposed joints solve
//     (2T_i - T_{i-1} - T_{i+1})/I = (moment_{i+1} - moment_i)/I - phi_i'',
// and so do those of joints with rotors, where phi_i'' = (T_i - driving torque) / rotor_i.
inline void implicit_mixed(const Robot& r, const std::vector<char>& imposed,
                           const std::vector<double>& rotor, const double* joint_accel,
                           std::vector<double>& scratch, Chain& k, Joints& joints) {
    const int n = k.n();
    for (int i = 0; i < n; ++i)
        k.alpha[i] = accelerate_link(r, k, joints, i);  // alpha holds the moments
    double ratio = 0;  // entry beside the diagonal of the last row after elimination
    for (int i = 0; i + 1 < n; ++i) {
        const double inertia_ratio = imposed[i] || rotor[i] == 0 ? 0 : r.I / rotor[i];
        if (!imposed[i] && inertia_ratio == 0) {
            ratio = 0;
            scratch[i] = 0;
            continue;
        }
        const double driving_torque =
            imposed[i] ? -r.I * joint_accel[i] : inertia_ratio * joints.T[i];
        const double right = k.alpha[i + 1] - k.alpha[i] + driving_torque;
        const double diagonal = 2 + inertia_ratio - ratio;
        joints.T[i] = (right + (i > 0 ? joints.T[i - 1] : 0)) / diagonal;
        ratio = 1 / diagonal;
        scratch[i] = ratio;
    }
    for (int i = n - 3; i >= 0; --i) joints.T[i] += scratch[i] * joints.T[i + 1];
    for (int i = 0; i < n; ++i) {
        const double T = (i + 1 < n ? joints.T[i] : 0.0) - (i > 0 ? joints.T[i - 1] : 0.0);
        k.alpha[i] = (T + k.alpha[i]) / r.I;
    }
}

}  // namespace serpenoid
