// DryMotion (exact sticking, explicit model, angles imposed) as a method: it takes the state of
// ExplicitAngle to the body frame and back. It chooses its own steps, to its own tolerance.
#pragma once

#include <array>

#include "dry_motion.hpp"
#include "gait.hpp"
#include "method.hpp"
#include "shape.hpp"
#include "tail_frame.hpp"

namespace serpenoid {

class SetValuedMotion : public Method {
  public:
    SetValuedMotion(const Robot& robot, const Ground& ground, const Gait& gait, double tolerance)
        : robot_(robot),
          omega_(gait.omega),
          tolerance_(tolerance),
          table_(robot.n, gait),
          motion_(robot, ground, gait) {}

    void restart(double t, const double* y) override {
        shape_at(t);
        const BodyState b = TailFrame(shape_).body(y, omega_);
        dry_ = {};
        dry_.v[DryState::Vx] = b.Vx, dry_.v[DryState::Vy] = b.Vy, dry_.v[DryState::L] = b.L;
        dry_.v[DryState::theta] = b.theta, dry_.v[DryState::x] = b.x, dry_.v[DryState::y] = b.y;
        t_ = t;
        std::copy_n(y, 6, y_.begin());
    }
    StepOutcome step(double t_limit) override {
        if (!motion_.advance(dry_, omega_ * t_, omega_ * t_limit, tolerance_))
            return {false, "the wheels stick and slip too often to be followed"};
        t_ = t_limit;
        give_back();
        return {};
    }
    double time() const override { return t_; }
    const double* state() const override { return y_.data(); }
    void dense(double, double* y) const override { std::copy_n(y_.begin(), 6, y); }

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

    Robot robot_;
    double omega_, tolerance_, t_ = 0;
    GaitTable table_;
    Shape shape_;
    DryMotion motion_;
    DryState dry_{};
    std::array<double, 6> y_{};
};

}  // namespace serpenoid
