// Starts and steps of lab_chain.hpp.
#include "lab/lab_chain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "numerics/cholesky.hpp"

namespace serpenoid {

namespace {

// Limits of the sweeps over contacts; tests/host/lab compares with closed forms.
struct ContactTuning {
    double rest_speed = 1e-5;     // m/s, limit below which a wheel is at rest
    double energy_error = 1e-20;  // J, impulse times speed change that ends the sweeps
    double immobile = 1e-24;      // 1/kg, inverse mass of a contact that cannot move
    int max_sweeps = 3000;
};
constexpr ContactTuning kContact;

}  // namespace

LabChain::LabChain(const Robot& robot, std::vector<LabLink> links, std::optional<Servo> servo)
    : robot_(robot),
      links_(std::move(links)),
      servo_(servo),
      n_(robot.n),
      size_(servo ? 2 + n_ : 3),
      theta_(n_),
      vx_(n_),
      vy_(n_),
      goal_(n_ - 1),
      max_rate_(n_ - 1),
      duty_(n_ - 1),
      torque_(n_ - 1),
      imposed_rate_(n_),
      rates_by_(size_ - 2, std::vector<double>(n_, servo ? 0.0 : 1.0)),
      u_(size_),
      mass_(size_ * size_),
      right_(size_),
      c_(n_),
      s_(n_),
      speeds_(2 * n_),
      link_(n_),
      contact_(servo ? 3 * n_ - 1 : 2 * n_) {
    for (Contact& contact : contact_) contact.row.assign(size_, 0.0);
    for (int i = 0; i < n_; ++i) {
        if (servo) rates_by_[i][i] = 1;
        link_[i].row.assign(size_, 0.0);
        link_[i].row[servo ? i + 2 : 2] = 1;
    }
    for (int i = 0; servo && i + 1 < n_; ++i) {
        gear(i).row[i + 3] = 1;
        gear(i).row[i + 2] = -1;
    }
    restart();
}

void LabChain::place(double x, double y, double theta, double vx, double vy, double w) {
    const double turn = theta - theta_[0];
    for (double& angle : theta_) angle += turn;
    x_ = x;
    y_ = y;
    std::fill(u_.begin(), u_.end(), w);
    u_[0] = vx;
    u_[1] = vy;
    heat_ = work_ = 0;
    restart();
}

void LabChain::set_joints(const std::vector<double>& angle) {
    for (int i = 0; i + 1 < n_; ++i) theta_[i + 1] = theta_[i] + angle[i];
    goal_ = angle;
    restart();
}

void LabChain::aim(const std::vector<double>& angle, double rate) {
    goal_ = angle;
    std::fill(max_rate_.begin(), max_rate_.end(), rate);
}

// Start from the present shape and velocity, with joints at rest and no contact impulses.
void LabChain::restart() {
    std::fill(imposed_rate_.begin(), imposed_rate_.end(), 0.0);
    since_update_ = HUGE_VAL;
    set_wheel_rows(0);
    for (Contact& contact : contact_) contact.impulse = 0;
    set_speeds();
}

bool LabChain::advance(double duration, double h) {
    // Rounding of the duration takes no step more.
    const int steps = std::max(1, static_cast<int>(std::ceil(duration / h - 1e-9)));
    for (int k = 0; k < steps; ++k)
        if (!step(duration / steps)) return false;
    return true;
}

bool LabChain::follow(const std::vector<double>& angle, double duration, double h) {
    goal_ = angle;
    for (int i = 0; i + 1 < n_; ++i) max_rate_[i] = std::fabs(angle[i] - joint_angle(i)) / duration;
    return advance(duration, h);
}

bool LabChain::step(double h) {
    if (servo_)
        update_duties(h);
    else
        turn_joints(h);
    set_wheel_rows(h);
    add_bodies(h);
    if (servo_) add_servos(h);
    add_friction(h);
    if (!solve()) return false;
    x_ += h * u_[0];
    y_ += h * u_[1];
    for (int i = 0; i < n_; ++i) theta_[i] += h * link_[i].speed;
    for (int i = 0; servo_ && i + 1 < n_; ++i) work_ += h * torque_[i] * gear(i).speed;
    return true;
}

void LabChain::turn_joints(double h) {
    for (int i = 0; i + 1 < n_; ++i) {
        const double rate = (goal_[i] - joint_angle(i)) / h;
        imposed_rate_[i + 1] = imposed_rate_[i] + std::clamp(rate, -max_rate_[i], max_rate_[i]);
    }
}

// Duties of the servos' loops, constant between two updates; without an update rate, new every
// step.
void LabChain::update_duties(double h) {
    const double hz = servo_->update_hz;
    const bool due = hz == 0 || since_update_ * hz >= 1 - 0.5 * h * hz;
    for (int i = 0; due && i + 1 < n_; ++i)
        duty_[i] = servo_->duty(goal_[i] - joint_angle(i), gear(i).speed);
    if (due) since_update_ = hz > 0 && since_update_ < HUGE_VAL ? since_update_ - 1 / hz : 0;
    since_update_ += h;
}

// Rows of the wheels at the shape in the middle of the step; offsets by imposed joints and ground.
void LabChain::set_wheel_rows(double h) {
    std::vector<double> angle = theta_;
    for (int i = 0; i < n_; ++i) {
        link_[i].offset = imposed_rate_[i];
        angle[i] += 0.5 * h * (link_[i].offset + dot(link_[i].row.data(), u_.data(), size_));
    }
    set_directions(angle);
    for (std::size_t j = 0; j < rates_by_.size(); ++j) {
        const std::vector<double>& speed = wheel_speeds(rates_by_[j]);
        for (int k = 0; k < 2 * n_; ++k) contact_[k].row[j + 2] = speed[k];
    }
    const std::vector<double>& speed = wheel_speeds(imposed_rate_);
    for (int k = 0; k < 2 * n_; ++k) {
        Contact& wheel = contact_[k];
        wheel.offset = speed[k] - wheel.row[0] * ground_x_ - wheel.row[1] * ground_y_;
    }
}

// Directions of the links at these angles, and the rows of the wheels for the centre's velocity.
void LabChain::set_directions(const std::vector<double>& angle) {
    for (int i = 0; i < n_; ++i) {
        c_[i] = std::cos(angle[i]);
        s_[i] = std::sin(angle[i]);
        std::vector<double>& t = contact_[2 * i].row;
        std::vector<double>& n = contact_[2 * i + 1].row;
        t[0] = n[1] = c_[i];
        t[1] = s_[i];
        n[0] = -s_[i];
    }
}

// The speeds of all wheels if the links turn at these rates and the centre of mass is at rest.
const std::vector<double>& LabChain::wheel_speeds(const std::vector<double>& rate) {
    double mean_x = 0;
    double mean_y = 0;
    for (const bool total : {true, false}) {
        double x = -mean_x;
        double y = -mean_y;
        for (int i = 0; i < n_; ++i) {
            if (i > 0) {
                x -= robot_.l * (rate[i - 1] * s_[i - 1] + rate[i] * s_[i]);
                y += robot_.l * (rate[i - 1] * c_[i - 1] + rate[i] * c_[i]);
            }
            if (total) {
                mean_x += x / n_;
                mean_y += y / n_;
            }
            speeds_[2 * i] = c_[i] * x + s_[i] * y;
            speeds_[2 * i + 1] = c_[i] * y - s_[i] * x;
        }
    }
    return speeds_;
}

// Add weight/2 (speed - target)^2 to the minimised function.
void LabChain::add_square(const Row& line, double weight, double target) {
    const double* row = line.row.data();
    add(right_.data(), size_, weight * (target - line.offset), row);
    for (int i = 0; i < size_; ++i)  // the upper triangle
        if (row[i] != 0) add(&mass_[i * size_ + i], size_ - i, weight * row[i], row + i);
}

void LabChain::add_bodies(double h) {
    std::fill(mass_.begin(), mass_.end(), 0.0);
    std::fill(right_.begin(), right_.end(), 0.0);
    for (int i = 0; i < n_; ++i) {
        const double x = vx_[i] + h * slope_.gx - ground_x_;
        const double y = vy_[i] + h * slope_.gy - ground_y_;
        add_square(contact_[2 * i], robot_.m, c_[i] * x + s_[i] * y);
        add_square(contact_[2 * i + 1], robot_.m, c_[i] * y - s_[i] * x);
        add_square(link_[i], robot_.I, link_[i].speed);
    }
    if (!guided_) return;
    // Exact constraints: stiff rails would still yield a little.
    right_[1] = right_[2] = 0;
    for (Contact& wheel : contact_) wheel.row[1] = wheel.row[2] = 0;
}

// Rotors, gears and torques: the motor's torque at the speed at the end of the step, constant duty.
void LabChain::add_servos(double h) {
    Supply load;
    for (int i = 0; i + 1 < n_; ++i) load.add(*servo_, duty_[i], gear(i).speed);
    const double volts = load.voltage(servo_->supply_sag);
    const double line = servo_->torque_limit / servo_->speed_limit + servo_->gear_damping;
    for (int i = 0; i + 1 < n_; ++i) {
        const double stall = servo_->torque_limit * volts * duty_[i];
        add_square(gear(i), servo_->armature, gear(i).speed);
        add_square(gear(i), h * line, stall / line);
        torque_[i] = stall - line * gear(i).speed;
        gear(i).high = h * servo_->gear_friction;
        gear(i).low = -gear(i).high;
    }
}

// Spin and friction of the wheels. Friction opposes the motion with c |v| + F0; at rest it balances
// the other forces, up to F0 times the breakaway ratio.
void LabChain::add_friction(double h) {
    for (int k = 0; k < 2 * n_; ++k) {
        Contact& wheel = contact_[k];
        const LabLink& link = links_[k / 2];
        const WheelLaw& f = k % 2 == 0 ? link.ground.along : link.ground.across;
        if (k % 2 == 0) add_square(wheel, link.rolling, wheel.speed);
        wheel.viscous = h * (wheel.speed < 0 ? f.c_back : f.c);
        add_square(wheel, wheel.viscous, 0);
        const double hold = std::fabs(wheel.speed) < kContact.rest_speed ? h * link.breakaway : h;
        wheel.low = -hold * f.f0;
        wheel.high = hold * f.f0_back;
    }
}

// Solve for u and all impulses; false if the result is not finite.
bool LabChain::solve() {
    cholesky(mass_.data(), size_);
    const auto solve_factored = [&](std::vector<double>& x) {
        forward(mass_.data(), size_, x.data());
        backward(mass_.data(), size_, x.data());
    };
    u_ = right_;
    solve_factored(u_);
    for (Contact& c : contact_) {
        c.response = c.row;
        solve_factored(c.response);
        const double inverse = dot(c.row.data(), c.response.data(), size_);
        c.mass = inverse > kContact.immobile ? 1 / inverse : 0;
        c.impulse = std::clamp(c.impulse, c.low, c.high);
        add(u_.data(), size_, c.impulse, c.response.data());
    }
    bool changed = true;
    for (int sweeps = 0; sweeps < kContact.max_sweeps && changed; ++sweeps) {
        changed = false;
        for (Contact& c : contact_) {
            const double v = c.offset + dot(c.row.data(), u_.data(), size_);
            const double change = std::clamp(c.impulse - c.mass * v, c.low, c.high) - c.impulse;
            if (change == 0) continue;
            c.impulse += change;
            add(u_.data(), size_, change, c.response.data());
            changed = changed || change * change > kContact.energy_error * c.mass;
        }
    }
    set_speeds();
    for (int k = 0; k < 2 * n_; ++k) {
        const Contact& wheel = contact_[k];
        heat_ += (wheel.viscous * wheel.speed - wheel.impulse) * wheel.speed;
    }
    return std::isfinite(u_[0] + u_[1] + u_[2]);
}

// Speeds of contacts and links from u.
void LabChain::set_speeds() {
    const auto set_speed = [&](Row& line) {
        line.speed = line.offset + dot(line.row.data(), u_.data(), size_);
    };
    std::for_each(contact_.begin(), contact_.end(), set_speed);
    std::for_each(link_.begin(), link_.end(), set_speed);
    for (int i = 0; i < n_; ++i) {
        const double t = contact_[2 * i].speed;
        const double n = contact_[2 * i + 1].speed;
        vx_[i] = c_[i] * t - s_[i] * n + ground_x_;
        vy_[i] = s_[i] * t + c_[i] * n + ground_y_;
    }
}

double LabChain::kinetic() const {
    double sum = 0;
    for (int i = 0; i < n_; ++i) {
        const double rate = link_[i].speed;
        const double spin = contact_[2 * i].speed;
        sum += robot_.m * (vx_[i] * vx_[i] + vy_[i] * vy_[i]) + robot_.I * rate * rate +
               links_[i].rolling * spin * spin;
    }
    for (std::size_t k = 2 * n_; k < contact_.size(); ++k)
        sum += servo_->armature * contact_[k].speed * contact_[k].speed;
    return 0.5 * sum;
}

std::vector<double> LabChain::places() {
    set_directions(theta_);
    const std::vector<double>& turn =
        wheel_speeds(std::vector<double>(n_, 1.0));  // x is vy, y is -vx
    std::vector<double> links;
    for (int i = 0; i < n_; ++i) {
        const double t = turn[2 * i];
        const double n = turn[2 * i + 1];
        links.insert(links.end(),
                     {x_ + s_[i] * t + c_[i] * n, y_ - c_[i] * t + s_[i] * n, theta_[i]});
    }
    return links;
}

}  // namespace serpenoid
