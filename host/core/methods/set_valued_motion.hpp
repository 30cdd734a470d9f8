// DryMotion (exact sticking, explicit model, angles imposed) as a method: it takes the state of
// ExplicitAngle to the body frame and back. It chooses its own steps, to its own tolerance.
#pragma once

#include <array>
#include <vector>

#include "body/body_shape.hpp"
#include "body/sticking_motion.hpp"
#include "methods/method.hpp"
#include "model/explicit_model.hpp"
#include "model/gait.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

class SetValuedMotion : public Method {
  public:
    explicit SetValuedMotion(const RunRequest& q)
        : robot_(q.robot),
          slope_(q.slope),
          omega_(q.gait.omega),
          tolerance_(q.tolerance),
          table_(q.robot.n, q.gait),
          motion_(q.robot, q.ground, q.gait, q.slope, kLeastBend),
          accel_(q.robot.n - 1) {
        motion_.climb();
    }

    void restart(double t, const double* y) override {
        shape_at(t);
        const BodyState b = TailFrame(shape_).body(y, omega_);
        dry_ = {};
        dry_.v[DryState::Vx] = b.Vx, dry_.v[DryState::Vy] = b.Vy, dry_.v[DryState::L] = b.L;
        dry_.v[DryState::theta] = b.theta, dry_.v[DryState::x] = b.x, dry_.v[DryState::y] = b.y;
        t_ = t;
        std::copy_n(y, 6, y_.begin());
        motion_.find_mode(dry_, omega_ * t);
    }
    void let_through(std::function<void()> ask) override { motion_.let_through(std::move(ask)); }
    StepOutcome step(double t_limit) override {
        // some cycles at a time, by the phase within a turn: after a day the phase itself would
        // be too coarse to find the ends of sticking
        const double to = std::min(t_limit, t_ + kMostCycles * kTurn / omega_);
        const double phase = std::fmod(omega_ * t_, kTurn);
        if (!motion_.advance(dry_, phase, phase + omega_ * (to - t_), tolerance_))
            return {false, "the wheels stick and slip too often to be followed"};
        t_ = to;
        give_back();
        return {};
    }
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    void dense(double, double* y) const override { std::copy_n(y_.begin(), 6, y); }
    void give_forces(double t, System& system) override {
        Chain& k = system.chain;
        motion_.friction(dry_, omega_ * t, wheel_force_);
        const double sin_tau = std::sin(omega_ * t), cos_tau = std::cos(omega_ * t);
        for (int i = 0; i < robot_.n; ++i) {
            const double ft = wheel_force_[2 * i], fn = wheel_force_[2 * i + 1];
            k.fx[i] = k.c[i] * ft - k.s[i] * fn + robot_.m * slope_.gx;
            k.fy[i] = k.s[i] * ft + k.c[i] * fn + robot_.m * slope_.gy;
            if (i + 1 < robot_.n)
                accel_[i] = omega_ * omega_ * table_.at(i, sin_tau, cos_tau).curvature;
        }
        explicit_angle(robot_, accel_.data(), k, system.joints);
    }

  private:
    void shape_at(double t) {
        shape_.set(robot_, table_, std::sin(omega_ * t), std::cos(omega_ * t), false);
    }
    void give_back() {
        shape_at(t_);
        const auto& v = dry_.v;
        const BodyState b{v[DryState::x],  v[DryState::y],  v[DryState::theta],
                          v[DryState::Vx], v[DryState::Vy], v[DryState::L]};
        TailFrame(shape_).tail(b, omega_, y_.data());
    }

    static constexpr double kTurn = 2 * 3.14159265358979323846, kMostCycles = 16;
    static constexpr double kLeastBend = 0.05;  // rad: of body lengths times omega it is little
    Robot robot_;
    Slope slope_;
    double omega_, tolerance_, t_ = 0;
    GaitTable table_;
    BodyShape shape_;
    DryMotion motion_;
    std::vector<double> accel_, wheel_force_;
    DryState dry_{};
    std::array<double, 6> y_{};
};

}  // namespace serpenoid
