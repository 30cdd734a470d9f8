// Gears with play for any explicit system: rotors turn by themselves, and teeth push the joints.
//
// The gap of a joint is its rotor's angle less its own, within half the play where no teeth touch.
// Beyond it teeth are springs, x deep, with a damper that grows with the depth up to some of it:
//     F = max(0, K x + D x' min(1, x / (kDamped depth))).
// K is such that the stalled torque presses teeth `depth` = kPressed of the play in; D takes the
// bounce from the lightest links. Teeth never pull. A rotor moves by the motor and the teeth alone,
//     J r' = tau - F;
// what holds the motor is the link, but its share is that of the gear ratio, and left out as it is
// for rotors without play.
#pragma once

#include <memory>
#include <vector>

#include "scene/paired_system.hpp"

namespace serpenoid {

// The torque of the teeth, from where the rotors are.
class Teeth final : public TorqueSource {
  public:
    explicit Teeth(const RunRequest& q);
    void torques(double t, const Chain& chain, double* T) override;
    std::vector<double> angle, rate;  // of the rotors

  private:
    static constexpr double kPressed = 0.005, kDamped = 0.25, kLight = 4;
    double half_, depth_, spring_, damper_;
};

// State: that of the inner system, then the angles of the rotors, then their rates.
class RotorSystem final : public PairedSystem {
  public:
    // The inner system is driven by the teeth.
    RotorSystem(const RunRequest& q, std::unique_ptr<PairedSystem> inner, Teeth& teeth);
    int dim() const override { return inner_->dim() + 2 * joints_; }
    std::vector<int> rate_of() const override;
    void set(const Chain& from, double* y) const override;
    void fill(double t, const double* y) override;
    void load(double t, const double* y) override;
    void accelerate() override;
    void rate(double t, const double* y, double* dy) override { forces(t, y), derivative(y, dy); }
    void derivative(const double* y, double* dy) const override;
    bool rate_fills_forces() const override { return true; }
    double next_jump(double t) const override { return servo_.next_jump(t); }
    void enter(double t, const double* y) override { fill(t, y), servo_.enter(t, chain); }

  private:
    bool turns(int joint) const { return faults_.empty() || faults_[joint] == Fault::none; }
    std::unique_ptr<PairedSystem> inner_;
    Teeth& teeth_;
    ServoTorque servo_;
    std::vector<Fault> faults_;
    int joints_;
    double armature_;
    bool placed_ = false;  // the rotors are where a state has them
};

}  // namespace serpenoid
