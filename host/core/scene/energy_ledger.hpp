// The energy balance of a run: four integrals behind the state of a system.
//
//     d/dt (kinetic + spring + height) = joints - friction - dampers
// with joints = -sum T_i phi_i', friction = -sum f_i . v_i >= 0, dampers = what the joint forces do
// beside the springs, sum (F_i - k Delta_i) . Delta_i' (which is c sum |Delta_i'|^2, but for the
// paper's scheme).
// The fourth integral is that of sum P_i^+, the energy of servos that do not regenerate. It has
// kinks, and is left to run/positive_work.hpp where a method has dense output.
#pragma once

#include <algorithm>

#include "scene/mechanics.hpp"

namespace serpenoid {

inline double joint_power(const Mechanics& m, std::size_t i) {
    return -m.joints.T[i] * (m.chain.omega[i + 1] - m.chain.omega[i]);
}

class EnergyLedger {
  public:
    static constexpr int kIntegrals = 4;             // joints, friction, dampers, P+
    static constexpr int kHeat = 1;                  // index of friction
    static constexpr int kColumns = 3 + kIntegrals;  // kinetic, spring, height, and the integrals

    explicit EnergyLedger(const RunRequest& request)
        : slope_(request.slope), stiffness_(request.spring.k) {}
    void leave_positive() { positive_ = false; }

    // Of the integrals, by the forces that the mechanics have.
    void rates(const Mechanics& m, double* rate) const {
        const Chain& k = m.chain;
        std::fill_n(rate, kIntegrals, 0.0);
        for (int i = 0; i + 1 < k.n(); ++i) {
            const double power = joint_power(m, i);
            rate[0] += power;
            if (positive_) rate[3] += std::max(power, 0.0);
        }
        for (std::size_t i = 0; i < m.gaps.size(); ++i) {
            const Gap& g = m.gaps[i];
            rate[2] += (m.joints.Fx[i] - stiffness_ * g.x) * g.vx +
                       (m.joints.Fy[i] - stiffness_ * g.y) * g.vy;
        }
        for (int i = 0; i < k.n(); ++i)
            rate[kHeat] -= (k.fx[i] - m.robot.m * slope_.gx) * k.vx[i] +
                           (k.fy[i] - m.robot.m * slope_.gy) * k.vy[i];
    }

    void row(const Mechanics& m, const double* integrals, double* row) const {
        const Chain& k = m.chain;
        std::fill_n(row, 3, 0.0);
        for (int i = 0; i < k.n(); ++i) {
            row[0] += 0.5 * m.robot.m * (k.vx[i] * k.vx[i] + k.vy[i] * k.vy[i]) +
                      0.5 * m.robot.I * k.omega[i] * k.omega[i];
            row[2] -= m.robot.m * (slope_.gx * k.x[i] + slope_.gy * k.y[i]);
        }
        for (const Gap& g : m.gaps) row[1] += 0.5 * stiffness_ * (g.x * g.x + g.y * g.y);
        std::copy_n(integrals, kIntegrals, row + 3);
    }

  private:
    Slope slope_;
    double stiffness_;
    bool positive_ = true;
};

}  // namespace serpenoid
