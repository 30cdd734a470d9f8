// Pieces and derivative of dry_cycle.hpp.
#include "periodic/dry_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/gait_batch.hpp"
#include "numerics/mean_positive_part.hpp"

namespace serpenoid {

namespace {

constexpr int s = SlidingPiece::kStages;
using Rule = SlidingPiece::Rule;
using Polynomial = StagePolynomial<s>;
using Stages = std::array<double, s>;

// What ends a mode, in units of the aim: at a stage, and between them, where the polynomial knows
// less. In between lies what rounding does.
constexpr double kBeyond = -2, kFarBeyond = -40;

// Integral from 0 to x of the polynomial through values at the stages, as weights.
Stages weights_to(double x) {
    const Rule& rule = Rule::get();
    Stages b{};
    if (x == 1) {
        for (int k = 0; k < s; ++k) b[k] = rule.a[(s - 1) * s + k];
        return b;
    }
    const Gauss<3>& gauss = Gauss<3>::get();  // exact for degree 5 > s - 1
    for (int q = 0; q < 3; ++q) {
        const double z = x * gauss.c[q];
        const auto w = rule.dense(z);
        for (int k = 0; k < s; ++k) b[k] += x * gauss.b[q] * w[k] * rule.c[k] / z;
    }
    return b;
}

// By the first p, of what is known by a piece's p.
Mat3 rows_by(const Mat3& T, const CycleState& from) {
    Mat3 B{};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            for (int c = 0; c < 3; ++c) B[3 * i + c] += T[3 * i + k] * from.by_start[k][c];
    return B;
}

}  // namespace

DryCycle::DryCycle(const Robot& robot, const Ground& ground, const Gait& gait)
    : robot_(robot),
      ground_(ground),
      alpha_(gait.alpha),
      omega_(gait.omega),
      nm_(robot.n * robot.m),
      table_(robot.n, gait),
      piece_(robot, ground, gait, instruction_sets().front()->stage),
      margin_(2 * robot.n),
      lowest_(2 * robot.n),
      torque_(robot.n),
      rate_(robot.n),
      fresh_(2 * robot.n) {
    const double v = gait.omega * robot.l * std::max(gait.alpha, 1e-9), arm = robot.n * robot.l;
    scale_ = {nm_ * v, nm_ * v, robot.n * (robot.I + robot.m * arm * arm / 12) * v / arm};
    mode_.sign.assign(2 * robot.n, 1.0);
    for (int i = 0; i + 1 < robot.n; ++i) lag_.push_back(table_.lag(i));
    for (int c = 0; c < 2 * robot.n; ++c) apart_.push_back(std::fmod(0.6180339887 * (c + 1), 1.0));
}

double DryCycle::momentum(double w, double tau) {
    shape_.set(robot_, table_, std::sin(tau), std::cos(tau), false);
    return shape_.J * w + omega_ * shape_.K;
}

double DryCycle::rate(double L, double tau) {
    shape_.set(robot_, table_, std::sin(tau), std::cos(tau), false);
    return (L - omega_ * shape_.K) / shape_.J;
}

// How far every wheel is from the end of its mode at the start and the stages, in units of the aim.
void DryCycle::margins() {
    piece_.speeds(margin_.data());
    for (int wheel = 0; wheel < 2 * robot_.n; ++wheel) {
        const double unit = mode_.sign[wheel] / speed_eps_;
        for (double& m : margin_[wheel].at) m *= unit;
    }
    for (int a = 0; a < mode_.count; ++a) {
        const int wheel = mode_.stuck[a];
        const double unit = piece_.grip(wheel) / force_eps_, mu = piece_.mu(wheel);
        for (int j = 0; j <= s; ++j) {
            const double f = j == 0 ? piece_.stuck_force(a, 0) : piece_.stage_force(j - 1, a);
            margin_[wheel].at[j] = unit * (1 - std::fabs(f) / mu);
        }
    }
}

// The first end of a wheel's mode before `first`: between the first pair of points of which the
// second is beyond it, or in a dip between them. A fraction of the piece, or `first`.
double DryCycle::end_of_wheel(const double* m, double first) const {
    const auto& c = Rule::get().c;
    const Polynomial p(m);
    const auto between = [&](double z, double before, double end, double value) {
        constexpr double kNear = 0.1;
        if (before <= -1) return z;
        return bracketed_root([&](double x) { return p(x) + 1; }, z, before + 1, end, value + 1,
                              kNear);
    };
    double found = first, z = 0;
    for (int j = 0; j < s && z < found; z = c[j++])
        if (m[j + 1] < kBeyond) found = std::min(found, between(z, m[j], c[j], m[j + 1]));
    Stretch<s> whole{0, 1, p.bernstein()}, dip;
    if (found < 1) whole = whole.cut(found);
    if (whole.first_below(kFarBeyond, 1.0 / 64, dip))
        found = std::min(found, between(dip.from, dip.b[0], dip.to, dip.b[s]));
    return found;
}

// Where a sliding wheel really stops: over a long piece its speed is no polynomial.
double DryCycle::sharpen(int wheel, double x) {
    const Polynomial p(margin_[wheel].at);
    for (int i = 0; i < 3; ++i) {
        const double off = mode_.sign[wheel] * piece_.speed(wheel, x) / speed_eps_ + 1;
        const double moved = -off / p.slope(x);
        if (std::fabs(off) < 0.5 || !(std::fabs(moved) < 0.01)) break;
        x = std::clamp(x + moved, 0.0, 1.0);
    }
    return x;
}

// The first end of a mode in the piece.
DryCycle::Ending DryCycle::ending() {
    margins();
    piece_.lowest(margin_.data(), lowest_.data());
    Ending first;
    for (int wheel = 0; wheel < 2 * robot_.n; ++wheel) {
        if (!piece_.has_modes(wheel) || lowest_[wheel] >= kBeyond) continue;
        const double at = end_of_wheel(margin_[wheel].at, first.at);
        if (at < first.at) first = {at, wheel, mode_.sign[wheel] != 0};
    }
    if (first.sliding && first.at > 0) first.at = sharpen(first.wheel, first.at);
    return first;
}

// Remember what the derivative needs of the moment when a sliding wheel stops.
void DryCycle::await_jump(const Ending& end, double h) {
    jump_.slope = Polynomial(margin_[end.wheel].at).slope(end.at) * speed_eps_ / h;
    jump_.rate = piece_.rate(end.at), jump_.waits = true;
    jump_.wheel = end.wheel, jump_.sign = mode_.sign[end.wheel];
}

void DryCycle::jump(const Vec3& after, CycleState& state) {
    jump_.waits = false;
    if (!(std::fabs(jump_.slope) > 1e-6 * scale_[0] / nm_)) return;
    Vec3 row;
    for (int c = 0; c < 3; ++c)
        row[c] =
            (jump_.gradient[0] * state.by_start[0][c] + jump_.gradient[1] * state.by_start[1][c] +
             jump_.gradient[2] * state.by_start[2][c]) /
            jump_.slope;
    for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 3; ++c) state.by_start[i][c] += (after[i] - jump_.rate[i]) * row[c];
}

// What friction takes, W, and its derivative by u.
std::pair<double, Vec3> DryCycle::dissipation(const SlidingPiece::Node& k, const Vec3& u) const {
    const double* D = k.D;
    const Vec3 drag = {D[0] * u[0] + D[1] * u[1] + D[2] * u[2] + omega_ * k.d[0],
                       D[1] * u[0] + D[3] * u[1] + D[4] * u[2] + omega_ * k.d[1],
                       D[2] * u[0] + D[4] * u[1] + D[5] * u[2] + omega_ * k.d[2]};
    Vec3 by;
    double watts = omega_ * (k.d[0] * u[0] + k.d[1] * u[1] + k.d[2] * u[2] + omega_ * k.dd);
    for (int i = 0; i < 3; ++i)
        watts += (drag[i] + k.dry[i]) * u[i], by[i] = 2 * drag[i] + k.dry[i];
    return {watts + omega_ * k.dry_e, by};
}

// Integrals over the first x of a piece of h, and the state there.
void DryCycle::accumulate(double h, double x, CycleState& state) {
    const Rule& rule = Rule::get();
    const Stages b = weights_to(x);
    const double dt = h / omega_;
    const CycleState from = state;
    std::array<Mat3, s> by;  // u at the stages by the first p
    for (int j = 0; j < s; ++j) {
        const double unit[3] = {1 / nm_, 1 / nm_, piece_.node(j + 1).iJ};
        by[j] = rows_by(piece_.stage_tangent(j), from);
        for (int i = 0; i < 9; ++i) by[j][i] *= unit[i / 3];
    }
    for (int j = 0; j < s; ++j) {
        const double w = dt * b[j];
        const Vec3& u = piece_.stage_velocity(j);
        double turn = from.theta;
        Vec3 turn_by = from.by_start[3];
        for (int k = 0; k < s; ++k) {
            const double a = dt * rule.a[j * s + k];
            turn += a * piece_.stage_velocity(k)[2];
            for (int c = 0; c < 3; ++c) turn_by[c] += a * by[k][6 + c];
        }
        const double heading = turn - spin_ * (tau_start_ + h * rule.c[j]);
        const double cn = std::cos(heading), sn = std::sin(heading);
        const double vx = cn * u[0] - sn * u[1], vy = sn * u[0] + cn * u[1];
        const auto [watts, watts_by] = dissipation(piece_.node(j + 1), u);
        state.theta += w * u[2], state.x += w * vx, state.y += w * vy;
        state.dissipated += w * watts;
        for (int c = 0; c < 3; ++c) {
            const double x_by = by[j][c], y_by = by[j][3 + c], w_by = by[j][6 + c];
            state.by_start[3][c] += w * w_by;
            state.by_start[4][c] += w * (cn * x_by - sn * y_by - vy * turn_by[c]);
            state.by_start[5][c] += w * (sn * x_by + cn * y_by + vx * turn_by[c]);
            state.by_start[6][c] +=
                w * (watts_by[0] * x_by + watts_by[1] * y_by + watts_by[2] * w_by);
        }
    }
    state.p = x == 1 ? piece_.stage(s - 1) : piece_.at(x);
    Mat3 B{};  // three wheels at rest leave nothing of a disturbance
    if (mode_.count < 3)
        B = rows_by(x == 1 ? piece_.stage_tangent(s - 1) : piece_.tangent(x), from);
    for (int i = 0; i < 9; ++i) state.by_start[i / 3][i % 3] = B[i];
}

bool DryCycle::advance(CycleState& state, double tau_end, double tolerance) {
    constexpr double kShortest = 1e-10;
    double tau = 0;
    speed_eps_ = std::max(0.01 * tolerance, 1e-12) * scale_[0] / nm_;
    force_eps_ = std::max(0.1 * tolerance, 1e-7);
    longest_kick_ = std::clamp(0.03 * std::sqrt(tolerance), 1e-6, 1e-3);
    shortest_kick_ =
        std::clamp(20 * speed_eps_ * nm_ * omega_ / ground_.least_dry(), 1e-7, longest_kick_);
    jump_.waits = false, kick_ = 0, skipped_ = 0;
    step_ = std::max(step_, 1e-3);  // it may have broken off at a very short one
    convex_.forget();
    if (!change_mode(state, tau, tau_end, {})) return false;
    int stalled = 0;
    while (tau < tau_end) {
        if (++pieces_ > most_) return false;
        double h = std::min(step_, tau_end - tau);
        if (tau_end - tau - h < 1e-9) h = tau_end - tau;
        tau_start_ = tau;
        if (!piece_.solve(mode_, tau, h, state.p, scale_, 0.1 * tolerance)) {
            step_ = h / 4;
            if (step_ < kShortest) return false;
            continue;
        }
        const double error = piece_.error(scale_) / tolerance;
        const double grow = std::clamp(0.8 * std::pow(error + 1e-30, -1.0 / (s + 1)), 0.1, 3.0);
        if (!(error < 1e30)) return false;
        if (error > 1.5) {
            step_ = h * std::min(grow, 0.7);
            if (step_ < kShortest) return false;
            continue;
        }
        if (jump_.waits) jump(piece_.rate(0), state);
        const Ending end = ending();
        if (end.wheel >= 0 && h * end.at < 1e-12) {
            if (++stalled > 40) return false;
            if (!change_mode(state, tau, tau_end, end)) return false;
            continue;
        }
        stalled = 0;
        if (positive_) add_positive(tau, h, end.at);
        skipped_ = 0;
        accumulate(h, end.at, state);
        step_ = std::min(h * grow, 0.8);
        if (h * end.at > 100 * kick_) kick_ = 0;
        if (end.wheel < 0) {
            tau = h == tau_end - tau ? tau_end : tau + h;
            continue;
        }
        if (end.sliding) await_jump(end, h);
        tau += h * end.at;
        if (tau < tau_end && !change_mode(state, tau, tau_end, end)) return false;
    }
    return true;
}

bool DryCycle::follow(const Vec3& p, double tau_end, double tolerance, double spin,
                      CycleState& to) {
    to = {};
    to.p = p, spin_ = spin;
    if (positive_) positive_->assign(robot_.n - 1, 0.0);
    net_work_ = doubtful_work_ = 0, together_ = false;
    std::fill(fresh_.begin(), fresh_.end(), 0);
    for (int i = 0; i < 3; ++i) to.by_start[i][i] = 1;
    return advance(to, tau_end, tolerance);
}

}  // namespace serpenoid
