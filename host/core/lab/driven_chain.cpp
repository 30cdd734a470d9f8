// The steps of driven_chain.hpp.
#include "lab/driven_chain.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

namespace {

constexpr double kHeld = 1e-5;      // m/s: a wheel that held has less
constexpr double kLeftOver = 1e-9;  // of an impulse times its speed, square root of J
constexpr int kMostSweeps = 3000;
constexpr double kEndless = 1e30;

// Lower triangle, reciprocals on the diagonal; false where the matrix is none of masses.
bool factorise(std::vector<double>& a, int n) {
    for (int j = 0; j < n; ++j) {
        for (int i = j; i < n; ++i) {
            double sum = a[i * n + j];
            for (int k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
            if (i == j && !(sum > 0)) return false;
            a[i * n + j] = i == j ? 1 / std::sqrt(sum) : sum * a[j * n + j];
        }
    }
    return true;
}

void solve_lower(const std::vector<double>& a, int n, double* x) {
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < i; ++k) x[i] -= a[i * n + k] * x[k];
        x[i] *= a[i * n + i];
    }
}

void solve_upper(const std::vector<double>& a, int n, double* x) {
    for (int i = n - 1; i >= 0; --i) {
        for (int k = i + 1; k < n; ++k) x[i] -= a[k * n + i] * x[k];
        x[i] *= a[i * n + i];
    }
}

double product(const double* a, const double* b, int n) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
}

}  // namespace

DrivenChain::DrivenChain(const Robot& robot, std::vector<LabLink> links, const Servo& servo)
    : robot_(robot),
      links_(std::move(links)),
      servo_(servo),
      n_(robot.n),
      size_(2 + robot.n + (servo.backlash > 0 ? robot.n - 1 : 0)),
      play_(servo.backlash > 0),
      theta_(n_),
      gap_(n_ - 1),
      u_(size_),
      along_x_(n_ * size_),
      along_y_(n_ * size_),
      vx_(n_),
      vy_(n_),
      goal_(n_ - 1),
      duty_(n_ - 1),
      torque_(n_ - 1),
      mass_(size_ * size_),
      right_(size_) {
    // wheels along and across of every link, then gears, then teeth
    contact_.resize(2 * n_ + (n_ - 1) * (play_ ? 2 : 1));
    for (Contact& c : contact_) c.row.assign(size_, 0.0);
    for (int i = 0; i + 1 < n_; ++i) {
        double* gear = contact_[2 * n_ + i].row.data();
        if (!play_) {
            gear[i + 3] = 1, gear[i + 2] = -1;
            continue;
        }
        gear[rotor(i)] = 1;
        Contact& teeth = contact_[3 * n_ - 1 + i];
        teeth.tooth = true;
        teeth.row[rotor(i)] = 1, teeth.row[i + 3] = -1, teeth.row[i + 2] = 1;
    }
}

void DrivenChain::place(double theta, const std::vector<double>& joints) {
    theta_[0] = theta, x_ = y_ = work_ = 0;
    for (int i = 0; i + 1 < n_; ++i) theta_[i + 1] = theta_[i] + joints[i];
    std::vector<double> here(2 + n_);
    state(here.data());
    x_ = -here[0], y_ = -here[1];
    for (auto* zeros : {&u_, &vx_, &vy_, &gap_}) std::fill(zeros->begin(), zeros->end(), 0.0);
    for (Contact& c : contact_) c.impulse = c.before = 0;
    goal_ = joints, since_update_ = kEndless;
}

void DrivenChain::state(double* to) const {
    double x = x_, y = y_, sum_x = 0, sum_y = 0;
    for (int i = 0; i < n_; ++i) {
        if (i > 0) {
            x += robot_.l * (std::cos(theta_[i - 1]) + std::cos(theta_[i]));
            y += robot_.l * (std::sin(theta_[i - 1]) + std::sin(theta_[i]));
        }
        sum_x += x, sum_y += y, to[2 + i] = theta_[i];
    }
    to[0] = sum_x / n_, to[1] = sum_y / n_;
}

double DrivenChain::kinetic() const {
    double sum = 0;
    for (int i = 0; i < n_; ++i) {
        const double c = std::cos(theta_[i]), s = std::sin(theta_[i]), t = c * vx_[i] + s * vy_[i];
        sum += robot_.m * (vx_[i] * vx_[i] + vy_[i] * vy_[i]) + robot_.I * u_[i + 2] * u_[i + 2] +
               links_[i].rolling * t * t;
    }
    for (int i = 0; i + 1 < n_; ++i) sum += servo_.armature * rotor_rate(i) * rotor_rate(i);
    return 0.5 * sum;
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
    contacts(h);
    if (!factorise(mass_, size_) || !sweep()) return false;
    for (int i = 0; i < n_; ++i) {
        vx_[i] = product(&along_x_[i * size_], u_.data(), size_);
        vy_[i] = product(&along_y_[i * size_], u_.data(), size_);
        theta_[i] += h * u_[i + 2];
    }
    x_ += h * u_[0], y_ += h * u_[1];
    for (int i = 0; i + 1 < n_; ++i) {
        work_ += h * torque_[i] * rotor_rate(i);
        if (play_) gap_[i] += h * (rotor_rate(i) - joint_rate(i));
    }
    return std::isfinite(x_ + y_ + theta_[0]);
}

// The velocities of all links as rows of u, in the shape of the middle of the step.
void DrivenChain::shape(double h) {
    std::fill(along_x_.begin(), along_x_.end(), 0.0);
    std::fill(along_y_.begin(), along_y_.end(), 0.0);
    const auto angle = [&](int i) { return theta_[i] + 0.5 * h * u_[i + 2]; };
    for (int i = 0; i < n_; ++i) {
        double *x = &along_x_[i * size_], *y = &along_y_[i * size_];
        x[0] = y[1] = 1;
        for (int j = 0; j <= i && i > 0; ++j) {
            const double lever = (j == 0 || j == i ? 1 : 2) * robot_.l;
            x[j + 2] = -lever * std::sin(angle(j)), y[j + 2] = lever * std::cos(angle(j));
        }
        double *t = contact_[2 * i].row.data(), *n = contact_[2 * i + 1].row.data();
        const double c = std::cos(angle(i)), s = std::sin(angle(i));
        for (int k = 0; k < size_; ++k) t[k] = c * x[k] + s * y[k], n[k] = c * y[k] - s * x[k];
    }
}

// Add weight/2 (row u - target)^2 to what is minimised.
void DrivenChain::add(const double* row, double weight, double target) {
    for (int i = 0; i < size_; ++i) {
        if (row[i] == 0) continue;
        right_[i] += weight * target * row[i];
        for (int j = 0; j <= i; ++j) mass_[i * size_ + j] += weight * row[i] * row[j];
    }
}

void DrivenChain::bodies(double h) {
    std::fill(mass_.begin(), mass_.end(), 0.0);
    std::fill(right_.begin(), right_.end(), 0.0);
    for (int i = 0; i < n_; ++i) {
        add(&along_x_[i * size_], robot_.m, vx_[i] + h * slope_.gx);
        add(&along_y_[i * size_], robot_.m, vy_[i] + h * slope_.gy);
        mass_[(i + 2) * (size_ + 1)] += robot_.I, right_[i + 2] += robot_.I * u_[i + 2];
        const double *t = contact_[2 * i].row.data(), *n = contact_[2 * i + 1].row.data();
        if (links_[i].rolling > 0) add(t, links_[i].rolling, contact_[2 * i].before);
        const Ground& g = links_[i].ground;
        add(t, h * WheelLaw::along(g).viscous(contact_[2 * i].before), 0);
        add(n, h * WheelLaw::across(g).viscous(0), 0);
    }
}

// Rotors, and torques: the motor's line at the end of the step, the loop's duty as it stands.
void DrivenChain::servos(double h) {
    Supply load;
    for (int i = 0; i + 1 < n_; ++i) load.add(servo_, duty_[i], rotor_rate(i));
    const double volts = load.voltage(servo_.supply_sag);
    const double line = servo_.torque_limit / servo_.speed_limit + servo_.gear_damping;
    for (int i = 0; i + 1 < n_; ++i) {
        const double* turning = contact_[2 * n_ + i].row.data();
        const double rate = rotor_rate(i), push = servo_.torque_limit * volts * duty_[i];
        add(turning, servo_.armature, rate);
        add(turning, h * line, push / line);
        torque_[i] = push - line * rate;
    }
}

void DrivenChain::contacts(double h) {
    for (int k = 0; k < static_cast<int>(contact_.size()); ++k) {
        Contact& c = contact_[k];
        if (c.tooth) {
            const double half = 0.5 * servo_.backlash, gap = gap_[k - (3 * n_ - 1)];
            c.low = (-half - gap) / h, c.high = (half - gap) / h;
            c.least = -kEndless, c.most = kEndless;
            continue;
        }
        double back = servo_.gear_friction, ahead = servo_.gear_friction;
        if (k < 2 * n_) {
            const LabLink& link = links_[k / 2];
            const WheelLaw law =
                k % 2 ? WheelLaw::across(link.ground) : WheelLaw::along(link.ground);
            const double more = std::fabs(c.before) < kHeld ? link.breakaway : 1;
            ahead = more * (law.bound - law.thrust), back = more * (law.bound + law.thrust);
        }
        c.least = -h * ahead, c.most = h * back;
        c.impulse = std::clamp(c.impulse, c.least, c.most);
    }
}

// Impulses of all contacts, one after another until none changes, and the velocities after them.
bool DrivenChain::sweep() {
    const int count = static_cast<int>(contact_.size());
    reach_.resize(count * size_), gram_.resize(count * count), speed_.resize(count);
    solve_lower(mass_, size_, right_.data());
    for (int k = 0; k < count; ++k) {
        double* r = &reach_[k * size_];
        std::copy(contact_[k].row.begin(), contact_[k].row.end(), r);
        solve_lower(mass_, size_, r);
        for (int j = 0; j <= k; ++j)
            gram_[k * count + j] = gram_[j * count + k] = product(r, &reach_[j * size_], size_);
    }
    for (int k = 0; k < count; ++k) {
        speed_[k] = product(&reach_[k * size_], right_.data(), size_);
        for (int j = 0; j < count; ++j) speed_[k] += gram_[k * count + j] * contact_[j].impulse;
    }
    bool settled = false;
    for (int look = 0; look < kMostSweeps && !settled; ++look) {
        settled = true;
        for (int k = 0; k < count; ++k) {
            Contact& c = contact_[k];
            const double weight = gram_[k * (count + 1)], now = c.impulse;
            const double up = now - (speed_[k] - c.high) / weight;
            const double down = now - (speed_[k] - c.low) / weight;
            const double wanted = up < 0 ? up : down > 0 ? down : 0;
            c.impulse = std::clamp(c.low < c.high ? wanted : up, c.least, c.most);
            const double by = c.impulse - now;
            if (by == 0) continue;
            if (std::fabs(by) * std::sqrt(weight) > kLeftOver) settled = false;
            for (int j = 0; j < count; ++j) speed_[j] += gram_[k * count + j] * by;
        }
    }
    for (int k = 0; k < count; ++k) {
        for (int i = 0; i < size_; ++i) right_[i] += contact_[k].impulse * reach_[k * size_ + i];
        contact_[k].before = speed_[k];
    }
    u_ = right_;
    solve_upper(mass_, size_, u_.data());
    return true;
}

}  // namespace serpenoid
