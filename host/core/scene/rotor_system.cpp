// The teeth and rotors of rotor_system.hpp.
#include "scene/rotor_system.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

Teeth::Teeth(const RunRequest& q)
    : angle(q.robot.n - 1), half_(0.5 * q.servo.backlash), depth_(kPressed * q.servo.backlash) {
    const double lightest = 1 / (1 / q.servo.armature + kLight / q.robot.I);
    spring_ = q.servo.torque_limit / depth_, damper_ = 2 * std::sqrt(spring_ * lightest);
}

void Teeth::torques(double, const Chain& k, double* T) {
    for (std::size_t i = 0; i < angle.size(); ++i) {
        const double gap = angle[i] - (k.theta[i + 1] - k.theta[i]);
        const double way = gap < 0 ? -1 : 1, deep = way * gap - half_;
        const double closing = way * (rate[i] - (k.omega[i + 1] - k.omega[i]));
        const double grip = std::min(1.0, deep / (kDamped * depth_));
        // on link i; the head side gets -T
        T[i] = deep > 0 ? -way * std::max(0.0, spring_ * deep + damper_ * grip * closing) : 0;
    }
}

RotorSystem::RotorSystem(const RunRequest& q, std::unique_ptr<PairedSystem> inner, Teeth& teeth)
    : PairedSystem(*inner, q.robot.n),
      inner_(std::move(inner)),
      teeth_(teeth),
      servo_(q.servo, q.gait, q.robot.n),
      faults_(q.faults),
      joints_(q.robot.n - 1),
      armature_(q.servo.armature) {
    rotor_rate.resize(joints_), rotor_accel.resize(joints_);
}

std::vector<int> RotorSystem::rate_of() const {
    std::vector<int> of = inner_->rate_of();
    for (int i = 0; i < joints_; ++i) of.push_back(inner_->dim() + joints_ + i);
    of.resize(dim(), -1);
    return of;
}

void RotorSystem::set(const Chain& k, double* y) const {
    inner_->set(k, y);
    double *angle = y + inner_->dim(), *rate = angle + joints_;
    for (int i = 0; i < joints_; ++i) {
        angle[i] = placed_ ? teeth_.angle[i] : k.theta[i + 1] - k.theta[i];
        rate[i] = placed_ ? rotor_rate[i] : k.omega[i + 1] - k.omega[i];
        if (!turns(i)) rate[i] = 0;
    }
}

void RotorSystem::fill(double t, const double* y) {
    inner_->fill(t, y);
    const double *angle = y + inner_->dim(), *rate = angle + joints_;
    teeth_.angle.assign(angle, rate), rotor_rate.assign(rate, rate + joints_);
    teeth_.rate = rotor_rate, placed_ = true;
}

void RotorSystem::load(double t, const double* y) {
    fill(t, y);
    inner_->load(t, y);
    servo_.torques(chain, rotor_rate.data(), driven.data());
}

void RotorSystem::accelerate() {
    inner_->accelerate();
    for (int i = 0; i < joints_; ++i)
        rotor_accel[i] = turns(i) ? (inner_->driven[i] - driven[i]) / armature_ : 0;
}

void RotorSystem::derivative(const double* y, double* dy) const {
    inner_->derivative(y, dy);
    const int at = inner_->dim();
    std::copy_n(y + at + joints_, joints_, dy + at);
    std::copy_n(rotor_accel.data(), joints_, dy + at + joints_);
}

}  // namespace serpenoid
