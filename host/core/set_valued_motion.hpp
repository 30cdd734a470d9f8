// DryMotion (exact sticking, explicit model, angles imposed) as a method: it takes the state of
// ExplicitAngle to the body frame and back. It chooses its own steps, to its own tolerance.
#pragma once

#include <array>

#include "dry_motion.hpp"
#include "gait.hpp"
#include "method.hpp"
#include "shape.hpp"

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
        const LinkShape& tail = shape_.link[0];
        const double c = std::cos(y[2]), s = std::sin(y[2]), w = omega_;
        dry_ = {};
        dry_.v[DryState::Vx] = c * y[3] + s * y[4] + y[5] * tail.ry - w * tail.rx1;
        dry_.v[DryState::Vy] = -s * y[3] + c * y[4] - y[5] * tail.rx - w * tail.ry1;
        dry_.v[DryState::L] = shape_.J * y[5] + w * shape_.K;
        dry_.v[DryState::theta] = y[2];
        dry_.v[DryState::x] = y[0] - (c * tail.rx - s * tail.ry);
        dry_.v[DryState::y] = y[1] - (s * tail.rx + c * tail.ry);
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
        const LinkShape& tail = shape_.link[0];
        const auto& v = dry_.v;
        const double c = std::cos(v[DryState::theta]), s = std::sin(v[DryState::theta]);
        const double turn = (v[DryState::L] - omega_ * shape_.K) / shape_.J;
        const double ux = v[DryState::Vx] - turn * tail.ry + omega_ * tail.rx1;
        const double uy = v[DryState::Vy] + turn * tail.rx + omega_ * tail.ry1;
        y_ = {v[DryState::x] + c * tail.rx - s * tail.ry,
              v[DryState::y] + s * tail.rx + c * tail.ry,
              v[DryState::theta],
              c * ux - s * uy,
              s * ux + c * uy,
              turn};
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
