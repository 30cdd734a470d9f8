// The modes, extrapolated steps and events of sticking_motion.hpp.
#include "body/sticking_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "body/joint_power.hpp"
#include "numerics/mean_positive_part.hpp"

namespace serpenoid {

DryMotion::DryMotion(const Robot& robot, const Ground& ground, const Gait& gait, const Slope& slope,
                     double least_bend)
    : robot_(robot),
      ground_(ground),
      slope_(slope),
      omega_(gait.omega),
      speed_scale_(gait.omega * robot.l * std::max(gait.alpha, least_bend)),
      arm_(robot.n * robot.l),
      along_(WheelLaw::along(ground)),
      across_(WheelLaw::across(ground)),
      grip_(along_.grip(robot.n * robot.m * omega_ * speed_scale_)),
      table_(robot.n, gait) {
    power_scale_ = robot.n * speed_scale_ * most_friction(ground, speed_scale_);
}

double DryMotion::momentum(double w, double tau) {
    shape_.set(robot_, table_, std::sin(tau), std::cos(tau), false);
    return shape_.J * w + omega_ * shape_.K;
}

double DryMotion::rate(double L, double tau) {
    shape_.set(robot_, table_, std::sin(tau), std::cos(tau), false);
    return (L - omega_ * shape_.K) / shape_.J;
}

// H and the kinks of one step of h seconds; b holds only the friction's part. Wheels of a straight
// chain have one and the same kink, where an active-set method could cycle: each kink is moved by
// its own 1e-11 or less of the speed scale, always the same, which leaves no two alike. The wheels
// of a ratchet go as their mode says, or as they went `before` (u), where no mode is known.
void DryMotion::assemble(double h, const double* before) {
    const double nm = robot_.n * robot_.m;
    H_ = {nm, 0, 0, 0, nm, 0, 0, 0, shape_.J};
    b_ = {0, 0, 0};
    kinks_.clear();
    const auto wheel = [&](const WheelDirection& row, const WheelLaw& law, double c) {
        const Vec3 g{row.x, row.y, row.r};
        const double e = omega_ * row.e, hc = h * c;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) H_[3 * i + j] += hc * g[i] * g[j];
            b_[i] -= (hc * e - h * law.thrust) * g[i];
        }
        if (!law.has_modes()) return;
        const double apart = std::fmod(0.6180339887 * static_cast<double>(kinks_.size() + 1), 1.0);
        kinks_.push_back({g, e + 1e-11 * speed_scale_ * apart, h * law.bound});
    };
    for (const LinkShape& link : shape_.link) {
        double direction = 0;
        if (!along_.one_viscous())
            direction = before ? link.t.speed(before, omega_)
                               : convex_.sign(static_cast<int>(kinks_.size()));
        wheel(link.t, along_, along_.viscous(direction));
        wheel(link.n, across_, across_.mean_viscous());
    }
}

// The shape has been set.
void DryMotion::wheel_forces(const DryState& state, std::vector<double>& force) {
    const double w = (state.v[DryState::L] - omega_ * shape_.K) / shape_.J;
    const double u[3] = {state.v[DryState::Vx], state.v[DryState::Vy], w};
    for (int a = 0; a < convex_.held_count(); ++a)
        convex_.set_sign(convex_.held_kink(a), std::clamp(state.v[DryState::stick + a], -1.0, 1.0));
    int kink = 0;
    force.clear();
    for (const LinkShape& k : shape_.link) {
        const double t = along_.has_modes() ? convex_.sign(kink++) : 0;
        const double n = across_.has_modes() ? convex_.sign(kink++) : 0;
        force.push_back(along_.force(k.t.speed(u, omega_), t));
        force.push_back(across_.force(k.n.speed(u, omega_), n));
    }
}

void DryMotion::friction(const DryState& state, double tau, std::vector<double>& force) {
    shape_.set(robot_, table_, std::sin(tau), std::cos(tau), false);
    wheel_forces(state, force);
}

// Powers of all joints at a state within the present mode, W; the i-th goes to power[i * stride].
void DryMotion::joint_power(const DryState& state, double tau, double* power, int stride) {
    shape_.set(robot_, table_, std::sin(tau), std::cos(tau), true);
    wheel_forces(state, wheel_force_);
    const double L = state.v[DryState::L];
    const Vec3 u{state.v[DryState::Vx], state.v[DryState::Vy], (L - omega_ * shape_.K) / shape_.J};
    const auto friction = [&](int i) {
        return std::pair{wheel_force_[2 * i], wheel_force_[2 * i + 1]};
    };
    double force[3] = {0, 0, 0};
    for (int i = 0; i < robot_.n; ++i) {
        const auto [ft, fn] = friction(i);
        const LinkShape& k = shape_.link[i];
        force[0] += ft * k.t.x + fn * k.n.x;
        force[1] += ft * k.t.y + fn * k.n.y;
        force[2] += ft * k.t.r + fn * k.n.r;
    }
    joint_powers(robot_, shape_, omega_,
                 BodyMotion::from_forces(robot_, shape_, omega_, u.data(), force), friction,
                 [&](int i, double T, double rate) { power[i * stride] = -T * rate; });
}

// Integrate sum P_i^+ over a step that is smooth, in pieces short enough for six points each.
bool DryMotion::add_positive(const DryState& from, double tau, double H, double tolerance) {
    constexpr int s = 6;
    constexpr double kLongest = 0.25;
    const Gauss<s>& rule = Gauss<s>::get();
    const int pieces = static_cast<int>(std::ceil(H / kLongest));
    std::vector<std::array<double, s>> power(robot_.n - 1);
    Step step;
    for (int k = 0; k < pieces; ++k) {
        for (int j = 0; j < s; ++j) {
            const double part = (k + rule.c[j]) * H / pieces;
            if (!extrapolate(from, tau, part, tolerance, step)) return false;
            joint_power(step.to, tau + part, &power[0][j], s);
        }
        for (const auto& p : power) {
            *positive_ += H / pieces / omega_ * mean_positive_part<s>(p);
            for (int j = 0; j < s; ++j) net_work_ += H / pieces / omega_ * rule.b[j] * p[j];
        }
    }
    return true;
}

void DryMotion::add_positive_of_event(const DryState& to, double tau, double length) {
    std::vector<double> power(robot_.n - 1);
    joint_power(to, tau, power.data(), 1);
    for (const double p : power) {
        net_work_ += length / omega_ * p;
        *positive_ += length / omega_ * std::max(p, 0.0);
    }
}

bool DryMotion::advance_with_power(DryState& state, double tau, double tau_end, double tolerance,
                                   double& positive) {
    positive_ = &positive, net_work_ = 0;
    const bool done = advance(state, tau, tau_end, tolerance);
    positive_ = nullptr;
    return done;
}

double DryMotion::dissipation(const Vec3& u) const {
    double sum = 0;
    for (const LinkShape& k : shape_.link) {
        const double t = k.t.speed(u.data(), omega_), n = k.n.speed(u.data(), omega_);
        sum += along_.dissipation(t) + across_.dissipation(n);
    }
    return sum;
}

// One implicit Euler step, its mode fixed or found; w is the turning rate at its start, then end.
bool DryMotion::euler(const DryState& from, double tau, double h_phase, bool fixed, DryState& to,
                      double& w) {
    const double h = h_phase / omega_, end = tau + h_phase;
    shape_.set(robot_, table_, std::sin(end), std::cos(end), false);
    const double before[3] = {from.v[DryState::Vx], from.v[DryState::Vy], w};
    assemble(h, fixed ? nullptr : before);
    const double nm = robot_.n * robot_.m, c = std::cos(h * w), s = std::sin(h * w);
    b_[0] += nm * (c * from.v[DryState::Vx] + s * from.v[DryState::Vy]);
    b_[1] += nm * (c * from.v[DryState::Vy] - s * from.v[DryState::Vx]);
    b_[2] += from.v[DryState::L] - omega_ * shape_.K;
    if (slope_.tilted()) {
        const double ahead = from.v[DryState::theta] + h * w;
        const double ca = std::cos(ahead), sa = std::sin(ahead);
        b_[0] += nm * h * (ca * slope_.gx + sa * slope_.gy);
        b_[1] += nm * h * (ca * slope_.gy - sa * slope_.gx);
    }
    ++systems_;
    if (!(fixed ? convex_.solve_fixed(H_, b_, kinks_) : convex_.solve(H_, b_, kinks_)))
        return false;
    const Vec3& u = convex_.minimum();
    w = u[2];
    const double theta = from.v[DryState::theta] + h * w, heading = theta - spin_ * end;
    const double ch = std::cos(heading), sh = std::sin(heading);
    DryState next;
    next.v = {u[0],
              u[1],
              shape_.J * w + omega_ * shape_.K,
              theta,
              from.v[DryState::x] + h * (ch * u[0] - sh * u[1]),
              from.v[DryState::y] + h * (sh * u[0] + ch * u[1]),
              from.v[DryState::dissipated] + h * dissipation(u)};
    for (int a = 0; a < convex_.held_count(); ++a)
        next.v[DryState::stick + a] = convex_.sign(convex_.held_kink(a));
    to = next;
    return true;
}

// Largest difference, as a fraction of the scale of each component over a radian of phase. Powers
// may be ten times coarser.
double DryMotion::error_norm(const DryState& a, const DryState& b) const {
    const double v = speed_scale_, energy = 10 * power_scale_ / omega_;
    const double turning = robot_.n * (robot_.I + robot_.m * arm_ * arm_ / 12) * v / arm_;
    const double scale[DryState::stick] = {v, v, turning, 1, v / omega_, v / omega_, energy};
    double most = 0;
    for (int i = 0; i < DryState::stick; ++i)
        most = std::max(most, std::fabs(a.v[i] - b.v[i]) / scale[i]);
    return most;
}

// How far every kink is from the end of its mode: positive inside, -1 the aim when it ends.
void DryMotion::margins(const DryState& s, double tau, std::vector<double>& margin) {
    const double u[3] = {s.v[DryState::Vx], s.v[DryState::Vy], rate(s.v[DryState::L], tau)};
    margin.clear();
    const auto wheel = [&](const WheelDirection& row, const WheelLaw& law) {
        if (!law.has_modes()) return;
        const int c = static_cast<int>(margin.size());
        margin.push_back(convex_.sign(c) * row.speed(u, omega_) / speed_eps_);
    };
    for (const LinkShape& k : shape_.link) wheel(k.t, along_), wheel(k.n, across_);
    for (int a = 0; a < convex_.held_count(); ++a)
        margin[convex_.held_kink(a)] =
            grip(convex_.held_kink(a)) * (1 - std::fabs(s.v[DryState::stick + a])) / stick_eps_;
}

// Fraction of the step at which the first mode ends: by the line through both ends, or, for a dip
// between them, by the parabola through the early point as well. 1 when none ends.
double DryMotion::event_before(const std::vector<double>& start, const Step& step) const {
    double first = 1;
    const double x = 1.0 / step.rows;
    for (std::size_t c = 0; c < start.size(); ++c) {
        const double m0 = start[c], m1 = step.early[c], m2 = step.margin[c];
        if (m2 < -2) {
            first = m0 <= 0 ? 0 : std::min(first, (m0 + 1) / (m0 - m2));
            continue;
        }
        const double curvature = ((m1 - m0) / x - (m2 - m0)) / (x - 1), slope = m2 - m0 - curvature;
        const double lowest = m0 - slope * slope / (4 * curvature);
        if (m0 > 0 && curvature > 0 && slope < 0 && slope > -2 * curvature && lowest < -2)
            first = std::min(first, (-slope - std::sqrt(slope * slope - 4 * curvature * (m0 + 1))) /
                                        (2 * curvature));
    }
    return first;
}

// Rows of the extrapolation table until two orders agree. Returns false when a system is singular.
bool DryMotion::extrapolate(const DryState& from, double tau, double H, double tolerance,
                            Step& step) {
    std::array<DryState, kMaxOrder + 1> row;
    DryState early;
    const double w0 = rate(from.v[DryState::L], tau);
    const int most = std::min(order_ + 1, kMaxOrder);
    for (int j = 1; j <= most; ++j) {
        DryState now = from;
        double w = w0;
        for (int i = 0; i < j; ++i) {
            if (!euler(now, tau + i * H / j, H / j, true, now, w)) return false;
            if (i == 0) early = now;
        }
        DryState lower = row[1];
        row[1] = now;
        for (int k = 1; k < j; ++k) {
            const DryState keep = row[k + 1];
            const double f = static_cast<double>(j - k) / k;  // 1 / (n_j/n_{j-k} - 1)
            for (int i = 0; i < DryState::size; ++i)
                row[k + 1].v[i] = row[k].v[i] + f * (row[k].v[i] - lower.v[i]);
            lower = keep;
        }
        if (j == 1) continue;
        step.to = row[j], step.rows = j;
        step.error[j] = error_norm(row[j], row[j - 1]) / tolerance;
        if (!(step.error[j] < 1e30)) return false;
        if (step.error[j] <= 1 && (j >= order_ || !climbs_)) break;
    }
    margins(early, tau + H / step.rows, step.early);
    margins(step.to, tau + H, step.margin);
    return true;
}

// Next step and order: those that get furthest per linear system (Hairer & Wanner, IV.9).
void DryMotion::control(const Step& step, double H, bool accepted) {
    double best = 0, best_step = 0;
    int order = 2;
    for (int j = 2; j <= step.rows; ++j) {
        const double grow = 0.9 * std::pow(std::max(step.error[j], 1e-10) / 0.5, -1.0 / j);
        const double h = H * std::clamp(grow, 0.1, 4.0), reach = h / (j * (j + 1));
        if (reach > best) best = reach, best_step = h, order = j;
    }
    if (accepted && order == step.rows) ++order;
    order_ = std::clamp(order, 3, kMaxOrder - 1);
    step_ = accepted ? std::min(best_step, 0.4) : std::min(best_step, 0.5 * H);
}

bool DryMotion::find_mode(DryState& state, double tau) {
    constexpr double kLook = 1e-5;  // rad; the sticking forces err by as much of their bounds
    double w = rate(state.v[DryState::L], tau);
    DryState ahead;
    convex_.forget();
    if (!euler(state, tau, kLook, false, ahead, w)) return false;
    std::copy_n(&ahead.v[DryState::stick], 3, &state.v[DryState::stick]);
    return true;
}

// A very short convex step, which finds the mode that follows. It is doubled when modes end at
// once, and when rounding hides the signs of its forces.
bool DryMotion::event_step(DryState& state, double& tau, double tau_end) {
    const double longest = std::min(10 * longest_event_step_, tau_end - tau);
    event_step_length_ = std::min(std::max(4 * event_step_length_, shortest_event_step_), longest);
    const double start = rate(state.v[DryState::L], tau);
    for (int attempt = 0; attempt < 12; ++attempt) {
        double w = start;
        if (euler(state, tau, event_step_length_, false, state, w)) {
            tau = event_step_length_ == tau_end - tau ? tau_end : tau + event_step_length_;
            if (positive_) add_positive_of_event(state, tau, event_step_length_);
            return true;
        }
        convex_.forget();
        if (attempt > 0) event_step_length_ = std::min(2 * event_step_length_, longest);
    }
    return false;
}

bool DryMotion::advance(DryState& state, double tau, double tau_end, double tolerance) {
    constexpr long kMostSteps = 200'000;
    speed_eps_ = std::max(0.003 * tolerance, 1e-13) * speed_scale_;
    stick_eps_ = std::max(0.1 * tolerance, 1e-6);
    // long enough for dry friction to undo the largest miss of an event, at both bounds
    longest_event_step_ =
        std::clamp(0.03 * std::sqrt(tolerance), 1e-7, 1e-4);  // it errs by its square
    shortest_event_step_ =
        std::clamp(20 * speed_eps_ * robot_.n * robot_.m * omega_ / least_dry(ground_), 1e-7,
                   longest_event_step_);
    convex_.forget();
    event_step_length_ = 0, step_ = std::max(step_, 1e-4);
    if (!event_step(state, tau, tau_end)) return false;
    std::vector<double> start;
    Step step;
    for (long steps = 0; tau < tau_end; ++steps) {
        if (steps > kMostSteps || systems_ > most_systems_ || !(step_ > 1e-14)) return false;
        if (let_through_) let_through_();
        margins(state, tau, start);
        double H = std::min(step_, tau_end - tau);
        if (tau_end - tau - H < 1e-12) H = tau_end - tau;
        if (!extrapolate(state, tau, H, tolerance, step)) {
            if (!event_step(state, tau, tau_end)) return false;
            continue;
        }
        const double at = event_before(start, step);
        if (at == 0) {
            if (!event_step(state, tau, tau_end)) return false;
            continue;
        }
        const bool accepted = step.error[step.rows] <= 1;
        const double usual = step_;
        if (at < 1 && accepted) {
            step_ = H * std::max(at, 1e-3);
            if (step_ < 1e-12) {
                if (!event_step(state, tau, tau_end)) return false;
                step_ = usual;
            }
            continue;
        }
        control(step, H, accepted);
        if (!accepted) continue;
        const DryState before = state;
        state = step.to, tau = H == tau_end - tau ? tau_end : tau + H;
        if (positive_) {
            const std::vector<double> margin = step.margin;
            if (!add_positive(before, tau - H, H, tolerance)) return false;
            step.margin = margin;
        }
        bool landed = false;
        for (std::size_t c = 0; c < step.margin.size(); ++c)
            landed = landed || (step.margin[c] <= 0 && step.margin[c] < start[c]);
        if (H > 100 * event_step_length_) event_step_length_ = 0;
        if (landed && tau < tau_end && !event_step(state, tau, tau_end)) return false;
        if (landed) step_ = std::max(step_, 0.05);
    }
    return true;
}

}  // namespace serpenoid
