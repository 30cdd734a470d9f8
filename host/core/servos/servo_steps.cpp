// The steps of servo_steps.hpp.
#include "servos/servo_steps.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "numerics/cholesky.hpp"

namespace serpenoid {

namespace {

// Modes of a step and roundings.
struct StepRevisions {
    int parallel = 6;              // revisions of all modes; then the worst one alone
    int max_count = 60;            // of revisions in a step
    double mode_rounding = 1e-9;   // of a bound: a larger excess ends rest
    double share = 1e-9;           // of the load, among more contacts than have to hold
    double frame_rounding = 1e-9;  // of a frame: events that near are simultaneous
    double step_rounding = 1e-6;   // of a step: so much too long is no reason for one more
};
constexpr StepRevisions kRevisions;

}  // namespace

ServoSteps::ServoSteps(const Robot& robot, const Ground& ground, const Gait& gait,
                       const Servo& servo, double longest)
    : robot_(robot),
      ground_(ground),
      gait_(gait),
      table_(robot.n, gait),
      servo_(servo),
      longest_(longest),
      n_(robot.n),
      size_(robot.n + 2),
      lever_(n_ * n_),
      inertia_(n_ * n_),
      theta_(n_),
      c_(n_),
      s_(n_),
      u_(size_),
      last_u_(size_),
      extrapolated_u_(size_),
      mass_(size_ * size_),
      right_(size_),
      goal_(n_ - 1),
      duty_(n_ - 1),
      stall_torque_(n_ - 1),
      torque_per_rate_(n_ - 1),
      tick_(servo.update_hz > 0 ? 1 / servo.update_hz : 0),
      period_(2 * std::numbers::pi / gait.omega) {
    wave_.assign(2 * (n_ - 1), 0.0);
    // centres from that of link 1 in half lengths of links, then from their mean
    for (int i = 1; i < n_; ++i)
        for (int j = 0; j <= i; ++j) lever_[i * n_ + j] = j == 0 || j == i ? 1 : 2;
    for (int j = 0; j < n_; ++j) {
        double mean = 0;
        for (int i = 0; i < n_; ++i) mean += lever_[i * n_ + j] / n_;
        for (int i = 0; i < n_; ++i) lever_[i * n_ + j] = (lever_[i * n_ + j] - mean) * robot.l;
    }
    for (int i = 0; i < n_; ++i)
        for (int j = 0; j < n_; ++j)
            for (int k = 0; k < n_; ++k)
                inertia_[i * n_ + j] += robot.m * lever_[k * n_ + i] * lever_[k * n_ + j];
    const auto touch = [&](double forward, double backward) {
        contact_.push_back(
            {std::vector<double>(size_), std::vector<double>(size_), forward, backward});
    };
    for (int i = 0; i < n_; ++i) {
        touch(ground.along.f0, ground.along.f0_back);
        touch(ground.across.f0, ground.across.f0_back);
    }
    for (int i = 0; i + 1 < n_; ++i) touch(servo.gear_friction, servo.gear_friction);
}

void ServoSteps::start(double vx, double vy, double rate) {
    u_[2] = rate;
    for (int i = 0; i + 1 < n_; ++i) {
        const GaitTable::Joint j = table_.joint(i, 0.0, 1.0);
        theta_[i + 1] = theta_[i] + j.angle;
        u_[i + 3] = u_[i + 2] + gait_.omega * j.slope;
    }
    u_[0] = vx;
    u_[1] = vy;
    last_u_ = u_;
    shift_frames(0.5);
}

// With these rates of the links.
double ServoSteps::momentum(const double* rate) const {
    double sum = 0;
    for (int i = 0; i < n_; ++i) {
        sum += robot_.I * rate[i];
        for (int j = 0; j < n_; ++j)
            sum += inertia_[i * n_ + j] * std::cos(theta_[i] - theta_[j]) * rate[j];
    }
    return sum;
}

void ServoSteps::body(double* v) const {
    const double c = std::cos(theta_[0]), s = std::sin(theta_[0]);
    v[0] = c * u_[0] + s * u_[1];
    v[1] = c * u_[1] - s * u_[0];
    v[2] = momentum(&u_[2]);
}

void ServoSteps::set_body(const double* v) {
    const double c = std::cos(theta_[0]), s = std::sin(theta_[0]);
    u_[0] = c * v[0] - s * v[1];
    u_[1] = s * v[0] + c * v[1];
    const std::vector<double> ones(n_, 1.0);
    const double turn = (v[2] - momentum(&u_[2])) / momentum(ones.data());
    for (int i = 0; i < n_; ++i) u_[i + 2] += turn;
    last_u_ = u_;
}

// The loop's duties from angles and rates as they stand.
void ServoSteps::control(const std::vector<double>& u) {
    for (int i = 0; i + 1 < n_; ++i)
        duty_[i] = servo_.duty(goal_[i] - (theta_[i + 1] - theta_[i]), joint(u, i));
}

void ServoSteps::shift_frames(double shift) { frame_ = update_ = (shift - 1) * servo_.frame; }

// Frames and updates that begin now; before the first step also those that have begun.
void ServoSteps::enter() {
    const double time = t_ + kRevisions.frame_rounding * servo_.frame;
    if (frame_ <= time) {
        while (frame_ + servo_.frame <= time) frame_ += servo_.frame;
        const double phase = gait_.omega * frame_, s = std::sin(phase), c = std::cos(phase);
        for (int i = 0; i + 1 < n_; ++i) goal_[i] = table_.joint(i, s, c).angle;
        frame_ += servo_.frame;
        last_u_ = u_;  // forces jump
    }
    if (tick_ == 0 || update_ > time) return;
    while (update_ <= time) update_ += tick_;
    control(u_);
    last_u_ = u_;
}

void ServoSteps::cycle() {
    const double heading = theta_[0];
    path_ = {};
    squares_ = work_ = 0;
    samples_.clear();
    std::fill(wave_.begin(), wave_.end(), 0.0);
    for (t_ = 0; t_ < period_ - kRevisions.frame_rounding * servo_.frame;) {
        enter();
        const double stop = std::min({period_, frame_, tick_ > 0 ? update_ : period_});
        const double steps = std::ceil((stop - t_) / longest_ - kRevisions.step_rounding);
        const int parts = split_ * std::max(1, static_cast<int>(steps));
        const double h = (stop - t_) / parts;
        for (int p = 0; p < parts; ++p) {
            step(h);
            if (after_step_) after_step_(h * split_ / period_);
        }
        t_ = stop;
    }
    frame_ -= period_;
    update_ -= period_;
    finish(theta_[0] - heading);
}

void ServoSteps::step(double h) {
    for (int i = 0; i < n_; ++i) {
        const double theta = theta_[i] += 0.5 * h * u_[i + 2];
        c_[i] = std::cos(theta);
        s_[i] = std::sin(theta);
    }
    for (int i = 0; i < size_; ++i) extrapolated_u_[i] = 1.5 * u_[i] - 0.5 * last_u_[i];
    last_u_ = u_;
    masses(h);
    drive(h);
    wheels(h);
    cholesky(mass_.data(), size_);
    slide(h);
    for (int i = 0; i < n_; ++i) theta_[i] += 0.5 * h * u_[i + 2];
    tally(h);
}

// M, and M u0 with the Coriolis forces.
void ServoSteps::masses(double h) {
    const int n = n_, size = size_;
    std::fill(mass_.begin(), mass_.end(), 0.0);
    mass_[0] = mass_[size + 1] = n_ * robot_.m;
    double* block = &mass_[2 * size + 2];
    std::fill(right_.begin(), right_.end(), 0.0);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j <= i; ++j) {
            const double a = inertia_[i * n + j];
            block[i * size + j] = block[j * size + i] = a * (c_[i] * c_[j] + s_[i] * s_[j]);
            const double turn = h * a * (s_[i] * c_[j] - c_[i] * s_[j]);
            right_[i + 2] -= turn * extrapolated_u_[j + 2] * extrapolated_u_[j + 2];
            right_[j + 2] += turn * extrapolated_u_[i + 2] * extrapolated_u_[i + 2];
        }
        block[i * size + i] += robot_.I;
    }
    for (int i = 0; i + 1 < n_; ++i) rotor_term(i, servo_.armature);
    for (int i = 0; i < size; ++i) right_[i] += dot(&mass_[i * size], u_.data(), size);
}

// Add f r^2 / 2 to the quadratic form of the matrix, r the rate of a rotor.
void ServoSteps::rotor_term(int i, double f) {
    double* block = &mass_[(i + 2) * size_ + i + 2];
    block[0] += f;
    block[size_ + 1] += f;
    block[1] -= f;
    block[size_] -= f;
}

// Servos' torques, linear in the rates of their joints.
void ServoSteps::drive(double h) {
    if (servo_.update_hz == 0) control(extrapolated_u_);
    Supply load;
    for (int i = 0; i + 1 < n_; ++i) load.add(servo_, duty_[i], joint(extrapolated_u_, i));
    const double V = load.voltage(servo_.supply_sag);
    const double line = servo_.torque_limit / servo_.speed_limit;
    for (int i = 0; i + 1 < n_; ++i) {
        double stall = servo_.torque_limit * V * duty_[i];
        double slope = line + servo_.gear_damping;
        // the loop's damping at the end of the step, too
        if (servo_.update_hz == 0 && std::fabs(duty_[i]) < 1) {
            const double more = V * (servo_.damping - line);
            stall += more * joint(extrapolated_u_, i);
            slope += more;
        }
        const double impulse = h * (stall - 0.5 * slope * joint(u_, i));
        right_[i + 3] += impulse;
        right_[i + 2] -= impulse;
        rotor_term(i, 0.5 * h * slope);
        stall_torque_[i] = stall;
        torque_per_rate_[i] = slope;
    }
}

// The rows of all contacts, and viscous friction.
void ServoSteps::wheels(double h) {
    const int n = n_;
    for (int i = 0; i < n; ++i) {
        double* __restrict along = contact_[2 * i].row.data();
        double* __restrict across = contact_[2 * i + 1].row.data();
        const double c = c_[i], s = s_[i];
        along[0] = c;
        along[1] = s;
        across[0] = -s;
        across[1] = c;
        for (int j = 0; j < n; ++j) {
            const double lever = lever_[i * n + j];
            along[j + 2] = lever * (s * c_[j] - c * s_[j]);
            across[j + 2] = lever * (c * c_[j] + s * s_[j]);
        }
    }
    for (int i = 0; i + 1 < n_; ++i) {
        double* g = contact_[2 * n_ + i].row.data();
        g[i + 2] = -1;
        g[i + 3] = 1;
    }
    for (int k = 0; k < static_cast<int>(contact_.size()); ++k) {
        Contact& contact = contact_[k];
        const double* g = contact.row.data();
        contact.speed = dot(g, u_.data(), size_);
        if (k >= 2 * n_) continue;
        const double c = (k % 2 ? ground_.across : ground_.along).viscous(contact.speed);
        if (c == 0) continue;
        const double damping = 0.5 * h * c;
        add(right_.data(), size_, -damping * contact.speed, g);
        for (int i = 0; i < size_; ++i)  // what the Cholesky factor reads
            add(&mass_[i * size_ + i], size_ - i, damping * g[i], g + i);
    }
}

double ServoSteps::bound(const Contact& c, int mode, double h) const {
    return mode > 0 ? -h * c.forward : h * c.backward;
}

// Find the impulses of all contacts, and u1.
void ServoSteps::slide(double h) {
    free_ = right_;  // without what is dry
    for (Contact& c : contact_) c.has_response = false;
    for (int revision = 0; revision < kRevisions.max_count; ++revision) {
        for (Contact& c : contact_) c.impulse = bound(c, c.mode, h);
        apply_impulses();
        if (!revise(h, revision < kRevisions.parallel)) break;
    }
    if (turn_round(h)) apply_impulses();
}

// u1 by the impulses of what slides, and by those that keep the rest at rest.
void ServoSteps::apply_impulses() {
    right_ = free_;
    resting_.clear();
    for (Contact& c : contact_) {
        if (c.dry() && c.mode == 0) resting_.push_back(&c);
        if (c.dry() && c.mode != 0) add(right_.data(), size_, c.impulse, c.row.data());
    }
    forward(mass_.data(), size_, right_.data());
    hold();
    u_ = right_;
    backward(mass_.data(), size_, u_.data());
}

void ServoSteps::hold() {
    const int k = static_cast<int>(resting_.size());
    if (k == 0) return;
    gram_.resize(k * k);
    pull_.resize(k);
    double trace = 0;
    for (int i = 0; i < k; ++i) {
        Contact& c = *resting_[i];
        if (!c.has_response) {
            c.response = c.row;
            forward(mass_.data(), size_, c.response.data());
        }
        c.has_response = true;
        const double* a = c.response.data();
        pull_[i] = -dot(a, right_.data(), size_);
        for (int j = 0; j <= i; ++j) gram_[j * k + i] = dot(a, resting_[j]->response.data(), size_);
        trace += gram_[i * k + i];
    }
    for (int i = 0; i < k; ++i) gram_[i * k + i] += kRevisions.share * trace;
    cholesky(gram_.data(), k);
    forward(gram_.data(), k, pull_.data());
    backward(gram_.data(), k, pull_.data());
    for (int i = 0; i < k; ++i) {
        Contact& c = *resting_[i];
        c.impulse = pull_[i];
        add(right_.data(), size_, c.impulse, c.response.data());
    }
}

// Change the modes that cannot be, all or the worst; tell whether there were any.
bool ServoSteps::revise(double h, bool all) {
    double largest = 0;
    Contact* worst = nullptr;
    int next_mode = 0;
    bool any = false;
    for (Contact& c : contact_) {
        if (!c.dry()) continue;
        double wrong = 0;
        int mode = 0;
        if (c.mode == 0) {
            const double excess = c.impulse - h * c.backward, deficit = -h * c.forward - c.impulse;
            wrong = std::max(excess, deficit) / (h * (c.forward + c.backward));
            if (wrong <= kRevisions.mode_rounding) continue;
            mode = excess > deficit ? -1 : 1;
        } else {
            const double v = dot(c.row.data(), u_.data(), size_);
            if (v * c.mode >= 0) continue;
            wrong = std::fabs(v) / (std::fabs(v) + std::fabs(c.speed));
        }
        any = true;
        if (all)
            c.mode = mode;
        else if (wrong > largest) {
            largest = wrong;
            worst = &c;
            next_mode = mode;
        }
    }
    if (worst) worst->mode = next_mode;
    return any;
}

// What goes the other way at the end of the step has the mean of both ways' friction.
bool ServoSteps::turn_round(double h) {
    bool any = false;
    for (Contact& c : contact_) {
        if (!c.dry() || c.mode * c.speed >= 0) continue;
        const double end_speed = std::fabs(dot(c.row.data(), u_.data(), size_));
        const double start_speed = std::fabs(c.speed);
        const double part = start_speed / (start_speed + end_speed);
        c.impulse = part * bound(c, -c.mode, h) + (1 - part) * bound(c, c.mode, h);
        any = true;
    }
    return any;
}

void ServoSteps::tally(double h) {
    const double middle = t_ + 0.5 * h, phase = gait_.omega * middle;
    samples_.push_back({middle, h, 0.5 * (last_u_[0] + u_[0]), 0.5 * (last_u_[1] + u_[1])});
    const double cosine = h * std::cos(phase), sine = h * std::sin(phase);
    for (int i = 0; i + 1 < n_; ++i) {
        const double rate = 0.5 * (joint(last_u_, i) + joint(u_, i));
        squares_ += h * rate * rate;
        wave_[2 * i] += cosine * rate;
        wave_[2 * i + 1] += sine * rate;
        work_ += h * (stall_torque_[i] - torque_per_rate_[i] * rate) * rate;
        const Contact& gear = contact_[2 * n_ + i];
        if (gear.dry()) work_ += gear.impulse * rate;
    }
    t_ += h;
}

void ServoSteps::finish(double turn) {
    double x = 0, y = 0;
    for (const Sample& sample : samples_) {
        const double c = std::cos(turn * sample.t / period_),
                     s = std::sin(turn * sample.t / period_);
        x += sample.h * (c * sample.vx + s * sample.vy);
        y += sample.h * (c * sample.vy - s * sample.vx);
    }
    path_.speed = std::hypot(x, y) / period_;
    path_.turn = turn;
    path_.power = work_ / period_;
    double cosines = 0, sines = 0, waves = 0, setpoints = 0;
    path_.gain.assign(n_ - 1, 1.0);
    path_.shift.assign(n_ - 1, 0.0);
    for (int i = 0; i + 1 < n_; ++i) {
        // rates a cos + b sin, over those of the gait: omega alpha gain cos(phase + lead)
        const double a = wave_[2 * i] * 2 / period_, b = wave_[2 * i + 1] * 2 / period_;
        const double want = gait_.omega * gait_.alpha;
        const double cosine = want * table_.cosine(i), sine = -want * table_.sine(i);
        const double in_phase = a * cosine + b * sine;
        const double quadrature = b * cosine - a * sine;
        const double square = cosine * cosine + sine * sine;
        cosines += in_phase;
        sines += quadrature;
        waves += a * a + b * b;
        setpoints += square;
        if (square > 0) {
            path_.gain[i] = std::hypot(a, b) / std::sqrt(square);
            path_.shift[i] = -std::atan2(quadrature, in_phase);
        }
    }
    if (setpoints > 0) path_.amplitude = std::sqrt(waves / setpoints);
    path_.lag = std::atan2(sines, cosines);
    path_.ripple = std::sqrt(std::max(0.0, squares_ / period_ - 0.5 * waves) / (n_ - 1));
}

}  // namespace serpenoid
