// The steps of driven_chain.hpp.
#include "lab/driven_chain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace serpenoid {

namespace {
constexpr double kEndless = 1e30;
}  // namespace

DrivenChain::DrivenChain(const Robot& robot, std::vector<LabLink> links, const Servo& servo)
    : LabChain(robot, std::move(links), 2 + robot.n, robot.n - 1),
      servo_(servo),
      theta_(n_),
      goal_(n_ - 1),
      duty_(n_ - 1),
      torque_(n_ - 1) {
    for (int i = 0; i + 1 < n_; ++i) {
        std::vector<double>& turning = gear(i).row;
        turning[i + 3] = 1;
        turning[i + 2] = -1;
    }
}

void DrivenChain::place(double theta, const std::vector<double>& joints) {
    theta_[0] = theta, x_ = y_ = work_ = 0;
    for (int i = 0; i + 1 < n_; ++i) theta_[i + 1] = theta_[i] + joints[i];
    for (auto* zeros : {&u_, &vx_, &vy_}) std::fill(zeros->begin(), zeros->end(), 0.0);
    for (Contact& c : contact_) c.impulse = c.before = 0;
    goal_ = joints, since_update_ = kEndless;
}

void DrivenChain::state(double* to) const {
    to[0] = x_, to[1] = y_;
    std::copy(theta_.begin(), theta_.end(), to + 2);
}

double DrivenChain::kinetic() const {
    double rotors = 0;
    for (int i = 0; i + 1 < n_; ++i) rotors += servo_.armature * joint_rate(i) * joint_rate(i);
    return LabChain::kinetic({u_.begin() + 2, u_.begin() + 2 + n_}) + 0.5 * rotors;
}

bool DrivenChain::frame(const std::vector<double>& setpoints, int steps) {
    goal_ = setpoints;
    const double h = servo_.frame / steps;
    for (int k = 0; k < steps; ++k) {
        if (servo_.update_hz == 0 ||
            since_update_ * servo_.update_hz >= 1 - 0.5 * h * servo_.update_hz) {
            control();
            since_update_ = since_update_ < kEndless && servo_.update_hz > 0
                                ? since_update_ - 1 / servo_.update_hz
                                : 0;
        }
        if (!step(h)) return false;
        since_update_ += h;
    }
    return true;
}

void DrivenChain::control() {
    for (int i = 0; i + 1 < n_; ++i)
        duty_[i] = servo_.duty(goal_[i] - joint_angle(i), joint_rate(i));
}

bool DrivenChain::step(double h) {
    shape(h);
    bodies(h);
    servos(h);
    gears(h);
    resist(h);
    if (!sweep()) return false;
    x_ += h * u_[0], y_ += h * u_[1];
    for (int i = 0; i < n_; ++i) theta_[i] += h * u_[i + 2];
    for (int i = 0; i + 1 < n_; ++i) work_ += h * torque_[i] * joint_rate(i);
    return true;
}

// The wheels' rows in the shape of the middle of the step.
void DrivenChain::shape(double h) {
    std::vector<double> links(n_);
    for (int i = 0; i < n_; ++i) links[i] = theta_[i] + 0.5 * h * u_[i + 2];
    point(links);
    for (int j = 0; j < n_; ++j) {
        std::fill(links.begin(), links.end(), 0.0);
        links[j] = 1;
        const std::vector<double>& alone = turning(links);
        for (int k = 0; k < 2 * n_; ++k) contact_[k].row[j + 2] = alone[k];
    }
}

void DrivenChain::bodies(double h) {
    std::fill(mass_.begin(), mass_.end(), 0.0);
    std::fill(right_.begin(), right_.end(), 0.0);
    for (int i = 0; i < n_; ++i) {
        const double x = vx_[i] + h * slope_.gx, y = vy_[i] + h * slope_.gy;
        add_square(contact_[2 * i], robot_.m, c_[i] * x + s_[i] * y);
        add_square(contact_[2 * i + 1], robot_.m, c_[i] * y - s_[i] * x);
        mass_[(i + 2) * (size_ + 1)] += robot_.I, right_[i + 2] += robot_.I * u_[i + 2];
    }
}

// Rotors, and torques: the motor's line at the end of the step, the loop's duty as it stands.
void DrivenChain::servos(double h) {
    Supply load;
    for (int i = 0; i + 1 < n_; ++i) load.add(servo_, duty_[i], joint_rate(i));
    const double volts = load.voltage(servo_.supply_sag);
    const double line = servo_.torque_limit / servo_.speed_limit + servo_.gear_damping;
    for (int i = 0; i + 1 < n_; ++i) {
        const double rate = joint_rate(i), push = servo_.torque_limit * volts * duty_[i];
        add_square(gear(i), servo_.armature, rate);
        add_square(gear(i), h * line, push / line);
        torque_[i] = push - line * rate;
    }
}

void DrivenChain::gears(double h) {
    for (int i = 0; i + 1 < n_; ++i) {
        gear(i).most = h * servo_.gear_friction;
        gear(i).least = -gear(i).most;
    }
}

}  // namespace serpenoid
