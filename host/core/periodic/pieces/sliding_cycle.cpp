// Pieces, events and derivative of sliding_cycle.hpp.
#include "periodic/pieces/sliding_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace serpenoid {

namespace {

// Lengths of pieces, rad, and what may happen on their way; held by dry gaits that once failed and
// by random ones (tests/host/periodic/test_dry_failures.py, test_dry_claims.py).
struct PieceLengths {
    double longest = 0.8;  // beyond it Newton's method seldom converges
    double smooth = 0.57;  // on smooth ground, at the tolerance below
    double smooth_tolerance = 6e-7;
    double shortest = 1e-10;
    double min_first = 1e-3;     // of the next cycle: the last one may have broken off
    double rounding = 1e-9;      // a last piece is not that short
    double at_once = 1e-12;      // an event so early is one more of the last one
    int max_at_once = 40;        // of those
    double quickly = 100;        // event steps: pieces so short come in quick succession
    double largest_error = 1.5;  // tolerances: the next pieces make up for it
    double diverged = 1e30;      // tolerances
    double shorter = 0.7;        // of a piece that failed, at most
    double safety = 0.8;         // of the length that the error allows
    double margins = 20;  // speed that friction undoes in an event step, over the aim of an event
    int event_steps = 6;  // event steps, each longer, until the wheel has changed
    double touch = 1e-6;  // of the speed scale, a rad: slower wheels only touch rest
};
constexpr PieceLengths kPieces;

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
    // Gauss' rule, exact for degree s: the nodes' distances from the middle, and weights
    constexpr double kGauss[3][2] = {
        {-0.3872983346207417, 5.0 / 18}, {0, 8.0 / 18}, {0.3872983346207417, 5.0 / 18}};
    b[0] = x;
    for (const auto& [distance, weight] : kGauss) {
        const auto w = rule.dense(x * (0.5 + distance));
        for (int k = 0; k < s; ++k) {
            const double part = x * weight * w[k];
            b[k + 1] += part;
            b[0] -= part;
        }
    }
    return b;
}

// By the first p, of what is known by a piece's p.
Mat3 rows_by(const Mat3& T, const CycleState& start) {
    Mat3 B{};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            for (int c = 0; c < 3; ++c) B[3 * i + c] += T[3 * i + k] * start.by_start[k][c];
    return B;
}

}  // namespace

SlidingCycle::SlidingCycle(const Robot& robot, const Ground& ground, const Gait& gait,
                           long most_pieces)
    : CycleMap(robot, gait),
      omega_(gait.omega),
      breakaway_force_(ground.breakaway_force()),
      piece_(robot, ground, gait),
      events_(robot, piece_),
      event_step_(*this, piece_),
      meter_(robot, gait, piece_, events_),
      most_pieces_(most_pieces) {
    mode_.sign.assign(2 * robot.n, 1.0);
}

// Event steps are long enough for dry friction to undo a whole miss of the event; their error goes
// with the square of their length. The same pieces at two tolerances would tell of no error, so on
// smooth ground the longest one goes with the tolerance, by the order of a piece's end.
CycleTolerances SlidingCycle::tolerances_of(double tolerance) const {
    CycleTolerances aim;
    // each a part of the tolerance, but more than rounding
    aim.speed = std::max(0.01 * tolerance, 1e-12) * scale_[0] / nm_;
    aim.force = std::max(0.1 * tolerance, 1e-7);
    aim.correction = std::max(10 * tolerance, 1e-8);
    aim.newton_step = smooth() ? std::max(tolerance * tolerance, 1e-15) : 0.1 * tolerance;
    aim.longest_piece = kPieces.longest;
    if (smooth()) {
        const double parts = std::pow(tolerance / kPieces.smooth_tolerance, 1.0 / (2 * s - 1));
        aim.longest_piece = std::min(kPieces.longest, kPieces.smooth * parts);
    }
    aim.longest_step = std::clamp(0.03 * std::sqrt(tolerance), 1e-6, 1e-3);
    aim.shortest_step = std::clamp(kPieces.margins * aim.speed * nm_ * omega_ / breakaway_force_,
                                   1e-7, aim.longest_step);
    return aim;
}

std::optional<CycleEnd> SlidingCycle::follow(const Vec3& p, const Following& how) {
    state_ = {};
    state_.p = p;
    for (int i = 0; i < 3; ++i) state_.by_start[i][i] = 1;
    tau_ = step_length_ = skipped_ = 0;
    tolerance_ = how.tolerance;
    spin_ = how.spin;
    simultaneous_ = saltation_.waits = false;
    tolerances_ = tolerances_of(how.tolerance);
    meter_.start(how.work, how.tolerance, tolerances_.speed);
    events_.set_units(tolerances_.speed, tolerances_.force);
    event_step_.limit_correction(tolerances_.correction);
    piece_length_ = std::max(piece_length_, kPieces.min_first);
    event_step_.forget();
    if (!advance()) return {};
    return CycleEnd{state_, meter_.work(), simultaneous_};
}

bool SlidingCycle::advance() {
    const double end = span();
    if (piece_.has_modes() && !change_mode({})) return false;
    for (int stalled = 0; tau_ < end;) {
        if (++pieces_ > most_pieces_) return false;
        double h = std::min(piece_length_, end - tau_);
        if (end - tau_ - h < kPieces.rounding) h = end - tau_;
        const Piece solved = solve_piece(h);
        if (solved == Piece::broken) return false;
        if (solved == Piece::shorter) continue;
        if (saltation_.waits) apply_saltation(piece_.rate(0));
        const ModeEvent event = events_.first_event(mode_, h);
        if (event.wheel >= 0 && h * event.fraction < kPieces.at_once) {
            if (++stalled > kPieces.max_at_once || !change_mode(event)) return false;
            continue;
        }
        stalled = 0;
        meter_.add(mode_, h, event.fraction, skipped_);
        skipped_ = 0;
        accumulate(h, event.fraction);
        piece_length_ = std::min(h * growth_, tolerances_.longest_piece);
        if (h * event.fraction > kPieces.quickly * step_length_) step_length_ = 0;
        if (event.sliding) {
            saltation_.waits = true;
            saltation_.slope = event.slope;
            saltation_.rate = piece_.rate(event.fraction);
        }
        tau_ = event.wheel < 0 && h == end - tau_ ? end : tau_ + h * event.fraction;
        if (event.wheel >= 0 && tau_ < end && !change_mode(event)) return false;
    }
    return true;
}

// Solve the next piece, or find how much shorter it must be.
SlidingCycle::Piece SlidingCycle::solve_piece(double h) {
    const auto shorter = [&](double length) {
        piece_length_ = length;
        return length < kPieces.shortest ? Piece::broken : Piece::shorter;
    };
    if (!piece_.solve(mode_, tau_, h, state_.p, scale_, tolerances_.newton_step))
        return shorter(h / 4);
    const double error = piece_.error(scale_) / tolerance_;
    growth_ = std::clamp(kPieces.safety * std::pow(error + 1e-30, -1.0 / (s + 1)), 0.1, 3.0);
    if (!(error < kPieces.diverged)) return Piece::broken;
    return error > kPieces.largest_error ? shorter(h * std::min(growth_, kPieces.shorter))
                                         : Piece::done;
}

// Find the mode that follows an event.
bool SlidingCycle::change_mode(const ModeEvent& event) {
    last_mode_ = mode_;
    if (!event_step(event)) return false;
    if (saltation_.waits) {
        const WheelDirection g = piece_.row(event.wheel, 0);
        const double sign = last_mode_.sign[event.wheel];
        saltation_.gradient = {sign * g.x / nm_, sign * g.y / nm_,
                               sign * g.r * piece_.node(0).inverse_J};
    }
    if (event.wheel >= 0) note_changes();
    return true;
}

// The step is lengthened until the wheel has changed, and from one event to the next when they come
// in quick succession: two wheels of an almost straight chain may take turns in stopping, for so
// short a time as cannot stop both.
bool SlidingCycle::event_step(const ModeEvent& event) {
    const double longest = tolerances_.longest_step;
    const CycleState start = state_;
    const double tau = tau_, sign = event.wheel < 0 ? 2 : mode_.sign[event.wheel];
    step_length_ = std::clamp(4 * step_length_, tolerances_.shortest_step, 10 * longest);
    double length = step_length_;
    for (int attempt = 1;; ++attempt) {
        state_ = start;
        const double dtau = std::min(length, span() - tau);
        if (!event_step_.take(state_, tau, dtau, spin_, last_mode_, event, mode_)) return false;
        tau_ = dtau == span() - tau ? span() : tau + dtau;
        const bool changed = event.wheel < 0 || mode_.sign[event.wheel] != sign;
        if (changed || length >= longest || attempt == kPieces.event_steps) {
            skipped_ += dtau;
            return true;
        }
        length = std::min(8 * length, std::max(step_length_, longest));
    }
}

void SlidingCycle::note_changes() {
    int slid = 0;
    for (int wheel = 0; wheel < piece_.wheels(); ++wheel) {
        if (mode_.sign[wheel] == last_mode_.sign[wheel]) continue;
        slid += last_mode_.sign[wheel] != 0;
        meter_.changed(wheel);
    }
    simultaneous_ = simultaneous_ || slid > 1;
}

void SlidingCycle::apply_saltation(const Vec3& rate_after) {
    saltation_.waits = false;
    if (!(std::fabs(saltation_.slope) > kPieces.touch * scale_[0] / nm_)) return;
    const Vec3& gradient = saltation_.gradient;
    auto& rows = state_.by_start;
    Vec3 delay;  // of the event, by the start
    for (int c = 0; c < 3; ++c)
        delay[c] =
            (gradient[0] * rows[0][c] + gradient[1] * rows[1][c] + gradient[2] * rows[2][c]) /
            saltation_.slope;
    for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 3; ++c) rows[i][c] += (rate_after[i] - saltation_.rate[i]) * delay[c];
}

// What friction takes, W, and its derivative by u.
std::pair<double, Vec3> SlidingCycle::dissipation(const SlidingPiece::Node& k,
                                                  const Vec3& u) const {
    const Vec3 drag = k.drag(u, omega_);
    Vec3 slope;
    double watts = k.dissipation(u, omega_) + omega_ * k.dry_e;
    for (int i = 0; i < 3; ++i) {
        watts += k.dry[i] * u[i];
        slope[i] = 2 * drag[i] + k.dry[i];
    }
    return {watts, slope};
}

// Integrals over the first x of a piece of h, and the state there.
void SlidingCycle::accumulate(double h, double x) {
    const Rule& rule = Rule::get();
    const Nodes b = weights_to(x);
    const double dt = h / omega_;
    const CycleState start = state_;
    std::array<Mat3, s + 1> u_by;  // u at the start and the stages by the first p
    for (int j = 0; j <= s; ++j) {
        const double unit[3] = {1 / nm_, 1 / nm_, piece_.node(j).inverse_J};
        u_by[j] = rows_by(j > 0 ? piece_.stage_tangent(j - 1) : identity3(), start);
        for (int i = 0; i < 9; ++i) u_by[j][i] *= unit[i / 3];
    }
    for (int j = x == 1; j <= s; ++j) {
        const double w = dt * b[j];
        const Vec3& u = piece_.velocity_at(j);
        double turn = start.theta;
        Vec3 turn_by = start.by_start[3];
        for (int k = 0; j > 0 && k < s; ++k) {
            const double a = dt * rule.a[(j - 1) * s + k];
            turn += a * piece_.velocity_at(k + 1)[2];
            for (int c = 0; c < 3; ++c) turn_by[c] += a * u_by[k + 1][6 + c];
        }
        const double heading = turn - spin_ * (tau_ + (j > 0 ? h * rule.c[j - 1] : 0));
        const double cn = std::cos(heading), sn = std::sin(heading);
        const double vx = cn * u[0] - sn * u[1], vy = sn * u[0] + cn * u[1];
        const auto [watts, watts_by] = dissipation(piece_.node(j), u);
        state_.theta += w * u[2];
        state_.x += w * vx;
        state_.y += w * vy;
        state_.dissipated += w * watts;
        for (int c = 0; c < 3; ++c) {
            const double x_by = u_by[j][c], y_by = u_by[j][3 + c], w_by = u_by[j][6 + c];
            state_.by_start[3][c] += w * w_by;
            state_.by_start[4][c] += w * (cn * x_by - sn * y_by - vy * turn_by[c]);
            state_.by_start[5][c] += w * (sn * x_by + cn * y_by + vx * turn_by[c]);
            state_.by_start[6][c] +=
                w * (watts_by[0] * x_by + watts_by[1] * y_by + watts_by[2] * w_by);
        }
    }
    state_.p = x == 1 ? piece_.stage(s - 1) : piece_.momenta(x);
    Mat3 B{};  // three wheels at rest leave nothing of a disturbance
    if (mode_.count < 3)
        B = rows_by(x == 1 ? piece_.stage_tangent(s - 1) : piece_.tangent(x), start);
    for (int i = 0; i < 9; ++i) state_.by_start[i / 3][i % 3] = B[i];
}

}  // namespace serpenoid
