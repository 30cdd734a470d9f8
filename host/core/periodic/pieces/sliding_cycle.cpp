// Pieces, events and derivative of sliding_cycle.hpp.
#include "periodic/pieces/sliding_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace serpenoid {

namespace {

constexpr int s = SlidingPiece::kStages;
using Rule = SlidingPiece::Rule;
using Nodes = std::array<double, s + 1>;  // of the start and the stages

// Integral from 0 to x, as weights: of the polynomial through the stages over the whole piece,
// where that is of order 2s - 1, and through the start, too, over a part.
Nodes weights_to(double x) {
    const Rule& rule = Rule::get();
    Nodes b{};
    if (x == 1) {
        for (int k = 0; k < s; ++k) b[k + 1] = rule.a[(s - 1) * s + k];
        return b;
    }
    const Gauss<3>& gauss = Gauss<3>::get();  // exact for degree s
    b[0] = x;
    for (int q = 0; q < 3; ++q) {
        const auto w = rule.dense(x * gauss.c[q]);
        for (int k = 0; k < s; ++k) {
            const double part = x * gauss.b[q] * w[k];
            b[k + 1] += part, b[0] -= part;
        }
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

SlidingCycle::SlidingCycle(const Robot& robot, const Ground& ground, const Gait& gait,
                           long most_pieces)
    : CycleMap(robot, gait),
      omega_(gait.omega),
      least_dry_(least_dry(ground)),
      piece_(robot, ground, gait),
      events_(robot, piece_),
      event_step_(*this, piece_),
      meter_(robot, gait, piece_, events_),
      most_pieces_(most_pieces) {
    mode_.sign.assign(2 * robot.n, 1.0);
}

// Event steps are long enough for dry friction to undo a whole miss of the event; their error goes
// with the square of their length.
void SlidingCycle::aim(double tolerance) {
    const double speed_eps = std::max(0.01 * tolerance, 1e-12) * scale_[0] / nm_;
    events_.aim(speed_eps, std::max(0.1 * tolerance, 1e-7));
    event_step_.aim(std::max(10 * tolerance, 1e-8));
    // by the order of a piece's end: the same pieces at two tolerances would tell of no error
    longest_piece_ = smooth() ? std::min(0.8, 0.57 * std::pow(tolerance / 6e-7, 1.0 / 9)) : 0.8;
    longest_step_ = std::clamp(0.03 * std::sqrt(tolerance), 1e-6, 1e-3);
    shortest_step_ = std::clamp(20 * speed_eps * nm_ * omega_ / least_dry_, 1e-7, longest_step_);
}

std::optional<CycleEnd> SlidingCycle::follow(const Vec3& p, const Following& how) {
    now_ = {};
    now_.p = p;
    for (int i = 0; i < 3; ++i) now_.by_start[i][i] = 1;
    tau_ = 0, tolerance_ = how.tolerance, spin_ = how.spin;
    simultaneous_ = false, saltation_.waits = false, step_length_ = skipped_ = 0;
    meter_.start(how.work, how.tolerance);
    aim(how.tolerance);
    piece_length_ = std::max(piece_length_, 1e-3);  // it may have broken off at a very short one
    event_step_.forget();
    if (!advance()) return {};
    return CycleEnd{now_, meter_.work(), simultaneous_};
}

bool SlidingCycle::advance() {
    const double end = span();
    if (piece_.has_modes() && !change_mode({})) return false;
    for (int stalled = 0; tau_ < end;) {
        if (++pieces_ > most_pieces_) return false;
        double h = std::min(piece_length_, end - tau_);
        if (end - tau_ - h < 1e-9) h = end - tau_;
        const Piece solved = solve_piece(h);
        if (solved == Piece::broken) return false;
        if (solved == Piece::shorter) continue;
        if (saltation_.waits) saltate(piece_.rate(0));
        const ModeEvent event = events_.first(mode_, h);
        if (event.wheel >= 0 && h * event.at < 1e-12) {
            if (++stalled > 40 || !change_mode(event)) return false;
            continue;
        }
        stalled = 0;
        meter_.add(mode_, h, event.at, skipped_);
        skipped_ = 0;
        accumulate(h, event.at);
        piece_length_ = std::min(h * growth_, longest_piece_);
        if (h * event.at > 100 * step_length_) step_length_ = 0;
        if (event.sliding) await_saltation(event);
        tau_ = event.wheel < 0 && h == end - tau_ ? end : tau_ + h * event.at;
        if (event.wheel >= 0 && tau_ < end && !change_mode(event)) return false;
    }
    return true;
}

// Solve the next piece, or find how much shorter it must be.
SlidingCycle::Piece SlidingCycle::solve_piece(double h) {
    constexpr double kShortest = 1e-10;
    const auto shorter = [&](double length) {
        piece_length_ = length;
        return length < kShortest ? Piece::broken : Piece::shorter;
    };
    // on smooth ground derivatives are to be as good as the motion: they miss Newton's last step
    const double close = smooth() ? std::max(tolerance_ * tolerance_, 1e-15) : 0.1 * tolerance_;
    if (!piece_.solve(mode_, tau_, h, now_.p, scale_, close)) return shorter(h / 4);
    const double error = piece_.error(scale_) / tolerance_;
    growth_ = std::clamp(0.8 * std::pow(error + 1e-30, -1.0 / (s + 1)), 0.1, 3.0);
    if (!(error < 1e30)) return Piece::broken;
    return error > 1.5 ? shorter(h * std::min(growth_, 0.7)) : Piece::done;
}

// Find the mode that follows an event.
bool SlidingCycle::change_mode(const ModeEvent& event) {
    before_ = mode_;
    if (!event_step(event)) return false;
    if (saltation_.waits) {
        const WheelDirection g = piece_.row(event.wheel, 0);
        const double sign = before_.sign[event.wheel];
        saltation_.gradient = {sign * g.x / nm_, sign * g.y / nm_, sign * g.r * piece_.node(0).iJ};
    }
    if (event.wheel >= 0) note_changes();
    return true;
}

// The step is lengthened until the wheel has changed, and from one event to the next when they come
// in quick succession: two wheels of an almost straight chain may take turns in stopping, for so
// short a time as cannot stop both.
bool SlidingCycle::event_step(const ModeEvent& event) {
    const CycleState before = now_;
    const double from = tau_, was = event.wheel < 0 ? 2 : mode_.sign[event.wheel];
    double length = step_length_ = std::clamp(4 * step_length_, shortest_step_, 10 * longest_step_);
    for (int attempt = 0; attempt < 6; ++attempt) {
        now_ = before;
        const double dtau = std::min(length, span() - from);
        if (!event_step_.take(now_, from, dtau, spin_, before_, event, mode_)) return false;
        tau_ = dtau == span() - from ? span() : from + dtau;
        const bool changed = event.wheel < 0 || mode_.sign[event.wheel] != was;
        if (changed || length >= longest_step_ || attempt == 5) {
            skipped_ += dtau;
            return true;
        }
        length = std::min(8 * length, std::max(step_length_, longest_step_));
    }
    return true;
}

void SlidingCycle::note_changes() {
    int slid = 0;
    for (int wheel = 0; wheel < piece_.wheels(); ++wheel) {
        if (mode_.sign[wheel] == before_.sign[wheel]) continue;
        slid += before_.sign[wheel] != 0;
        meter_.changed(wheel);
    }
    simultaneous_ = simultaneous_ || slid > 1;
}

void SlidingCycle::await_saltation(const ModeEvent& event) {
    saltation_.waits = true;
    saltation_.slope = event.slope, saltation_.rate = piece_.rate(event.at);
}

void SlidingCycle::saltate(const Vec3& after) {
    saltation_.waits = false;
    if (!(std::fabs(saltation_.slope) > 1e-6 * scale_[0] / nm_)) return;
    const Vec3& gradient = saltation_.gradient;
    auto& by = now_.by_start;
    Vec3 row;
    for (int c = 0; c < 3; ++c)
        row[c] = (gradient[0] * by[0][c] + gradient[1] * by[1][c] + gradient[2] * by[2][c]) /
                 saltation_.slope;
    for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 3; ++c) by[i][c] += (after[i] - saltation_.rate[i]) * row[c];
}

// What friction takes, W, and its derivative by u.
std::pair<double, Vec3> SlidingCycle::dissipation(const SlidingPiece::Node& k,
                                                  const Vec3& u) const {
    const Vec3 drag = k.drag(u, omega_);
    Vec3 by;
    double watts = k.dissipation(u, omega_) + omega_ * k.dry_e;
    for (int i = 0; i < 3; ++i) watts += k.dry[i] * u[i], by[i] = 2 * drag[i] + k.dry[i];
    return {watts, by};
}

// Integrals over the first x of a piece of h, and the state there.
void SlidingCycle::accumulate(double h, double x) {
    const Rule& rule = Rule::get();
    const Nodes b = weights_to(x);
    const double dt = h / omega_;
    const CycleState from = now_;
    std::array<Mat3, s + 1> by;  // u at the start and the stages by the first p
    for (int j = 0; j <= s; ++j) {
        const double unit[3] = {1 / nm_, 1 / nm_, piece_.node(j).iJ};
        by[j] = rows_by(j > 0 ? piece_.stage_tangent(j - 1) : identity3(), from);
        for (int i = 0; i < 9; ++i) by[j][i] *= unit[i / 3];
    }
    for (int j = x == 1; j <= s; ++j) {
        const double w = dt * b[j];
        const Vec3& u = piece_.velocity_at(j);
        double turn = from.theta;
        Vec3 turn_by = from.by_start[3];
        for (int k = 0; j > 0 && k < s; ++k) {
            const double a = dt * rule.a[(j - 1) * s + k];
            turn += a * piece_.velocity_at(k + 1)[2];
            for (int c = 0; c < 3; ++c) turn_by[c] += a * by[k + 1][6 + c];
        }
        const double heading = turn - spin_ * (tau_ + (j > 0 ? h * rule.c[j - 1] : 0));
        const double cn = std::cos(heading), sn = std::sin(heading);
        const double vx = cn * u[0] - sn * u[1], vy = sn * u[0] + cn * u[1];
        const auto [watts, watts_by] = dissipation(piece_.node(j), u);
        now_.theta += w * u[2], now_.x += w * vx, now_.y += w * vy;
        now_.dissipated += w * watts;
        for (int c = 0; c < 3; ++c) {
            const double x_by = by[j][c], y_by = by[j][3 + c], w_by = by[j][6 + c];
            now_.by_start[3][c] += w * w_by;
            now_.by_start[4][c] += w * (cn * x_by - sn * y_by - vy * turn_by[c]);
            now_.by_start[5][c] += w * (sn * x_by + cn * y_by + vx * turn_by[c]);
            now_.by_start[6][c] +=
                w * (watts_by[0] * x_by + watts_by[1] * y_by + watts_by[2] * w_by);
        }
    }
    now_.p = x == 1 ? piece_.stage(s - 1) : piece_.at(x);
    Mat3 B{};  // three wheels at rest leave nothing of a disturbance
    if (mode_.count < 3)
        B = rows_by(x == 1 ? piece_.stage_tangent(s - 1) : piece_.tangent(x), from);
    for (int i = 0; i < 9; ++i) now_.by_start[i / 3][i % 3] = B[i];
}

}  // namespace serpenoid
