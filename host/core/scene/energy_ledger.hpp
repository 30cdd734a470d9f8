// The energy balance of a run: a system with four integrals behind its state.
//
//     d/dt (kinetic + spring + height) = joints - friction - dampers
// with joints = -sum T_i phi_i', friction = -sum f_i . v_i >= 0, dampers = what the joint forces do
// beside the springs, sum (F_i - k Delta_i) . Delta_i' (which is c sum |Delta_i'|^2, but for the
// paper's scheme).
// The fourth integral is that of sum P_i^+, the energy of servos that do not regenerate. It has
// kinks, and is left to run/positive_work.hpp where a method has dense output.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "model/implicit_model.hpp"
#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

class EnergyLedger final : public System {
  public:
    static constexpr int kColumns = 7;  // kinetic, spring, height, joints, friction, dampers, P+

    EnergyLedger(std::unique_ptr<System> of, const RunRequest& q)
        : System(*of), inner_(std::move(of)), robot_(q.robot), slope_(q.slope), spring_(q.spring) {
        if (q.formulation == Formulation::explicit_) spring_ = {0, 0};
    }

    // Where friction's heat is in a state of so many numbers, the ledger's four at its end.
    static std::size_t heat_at(std::size_t dim) { return dim - 3; }

    int dim() const override { return inner_->dim() + 4; }
    void set(const Chain& from, double* y) const override {
        inner_->set(from, y);
        std::fill_n(y + inner_->dim(), 4, 0.0);
    }
    void leave_positive() { positive_ = false; }

    // P_i of every joint.
    void powers(double t, const double* y, std::vector<double>& power) {
        inner_->forces(t, y);
        for (std::size_t i = 0; i < power.size(); ++i) power[i] = joint_power(i);
    }

    void fill(double t, const double* y) override { inner_->fill(t, y); }
    void forces(double t, const double* y) override { inner_->forces(t, y); }
    void rate(double t, const double* y, double* dy) override {
        inner_->rate(t, y, dy);
        if (!inner_->rate_fills_forces()) inner_->forces(t, y);
        const Chain& k = chain;
        double *to = dy + inner_->dim(), joint = 0, spent = 0, lost = 0, damped = 0;
        for (int i = 0; i + 1 < k.n(); ++i) {
            const double power = joint_power(i);
            const Gap g = gap(k, robot_.l, i);
            joint += power, spent += std::max(power, 0.0);
            if (spring_.c == 0) continue;
            damped += (joints.Fx[i] - spring_.k * g.x) * g.vx;
            damped += (joints.Fy[i] - spring_.k * g.y) * g.vy;
        }
        for (int i = 0; i < k.n(); ++i)
            lost -= (k.fx[i] - robot_.m * slope_.gx) * k.vx[i] +
                    (k.fy[i] - robot_.m * slope_.gy) * k.vy[i];
        to[0] = joint, to[1] = lost, to[2] = damped, to[3] = positive_ ? spent : 0;
    }
    std::vector<int> rate_of() const override {
        std::vector<int> of = inner_->rate_of();
        of.resize(dim(), -1);
        return of;
    }
    double next_jump(double t) const override { return inner_->next_jump(t); }
    void enter(double t, const double* y) override { inner_->enter(t, y); }
    Modes* modes() override { return inner_->modes(); }
    void latch() override { inner_->latch(); }

    // One row of the ledger; the chain must have been filled from y.
    void row(const double* y, double* to) const {
        const Chain& k = chain;
        std::fill_n(to, 3, 0.0);
        for (int i = 0; i < k.n(); ++i) {
            to[0] += 0.5 * robot_.m * (k.vx[i] * k.vx[i] + k.vy[i] * k.vy[i]) +
                     0.5 * robot_.I * k.omega[i] * k.omega[i];
            to[2] -= robot_.m * (slope_.gx * k.x[i] + slope_.gy * k.y[i]);
        }
        for (int i = 0; i + 1 < k.n(); ++i) {
            const Gap g = gap(k, robot_.l, i);
            to[1] += 0.5 * spring_.k * (g.x * g.x + g.y * g.y);
        }
        std::copy_n(y + inner_->dim(), 4, to + 3);
    }

  private:
    double joint_power(std::size_t i) const {
        return -joints.T[i] * (chain.omega[i + 1] - chain.omega[i]);
    }
    std::unique_ptr<System> inner_;
    Robot robot_;
    Slope slope_;
    JointSpring spring_;
    bool positive_ = true;
};

}  // namespace serpenoid
