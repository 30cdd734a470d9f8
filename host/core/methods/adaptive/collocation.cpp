// The march over the pieces of collocation.hpp.
#include "methods/adaptive/collocation.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace serpenoid {

Collocation::Collocation(const Robot& robot, const Ground& ground, const Gait& gait,
                         double tolerance)
    : robot_(robot),
      ground_(ground),
      omega_(gait.omega),
      tolerance_(tolerance),
      mirrored_(gait.offset == 0),
      table_(robot.n, gait) {
    span_ = mirrored_ ? std::numbers::pi : 2 * std::numbers::pi, coarsest_ = mirrored_ ? 1 : 2;
    const double body = 2 * robot.l * robot.n;
    const double scale[] = {body * omega_, body * omega_, omega_, 1, body, body};  // L: times J
    std::copy_n(scale, PhaseElement::count, scale_);
}

void Collocation::restart(double t, const double* y) {
    if (t != origin_s_) kept_.clear();
    origin_s_ = t_ = from_s_ = to_s_ = t;
    spans_ = pieces_ = 0, side_ = 1, piece_ = Piece{1} << (coarsest_ + 2);
    shape_.set(robot_, table_, std::sin(omega_ * t), std::cos(omega_ * t), false);
    end_ = TailFrame(shape_).body(y, omega_);
    std::copy_n(y, 6, y_.begin());
}

int Collocation::level() const { return static_cast<int>(std::bit_width(piece_)) - 1; }

// Where the i-th piece of the present level begins, within the span.
double Collocation::phase(Piece i) const {
    return span_ * std::ldexp(static_cast<double>(i), -level());
}

PhaseElement& Collocation::element() {
    const auto found = kept_.find(piece_);
    if (found != kept_.end()) return found->second;
    if (kept_.size() >= kMostKept) kept_.clear();
    const double tau = omega_ * origin_s_ + phase(piece_ - std::bit_floor(piece_)), h = phase(1);
    return kept_.try_emplace(piece_, robot_, ground_, table_, omega_, tau, h, scratch_)
        .first->second;
}

// Solve the piece from end_; returns its error over the tolerance.
double Collocation::solve(PhaseElement& element) {
    now_.start = {end_.Vx, side_ * end_.Vy, side_ * end_.L};
    if (!element.solve(1e-4 * tolerance_ * scale_[0], now_))
        return std::numeric_limits<double>::infinity();
    const double bump = PhaseElement::Rule::get().bump_height / tolerance_;
    double most = 0;
    for (int c = 0; c < PhaseElement::count; ++c) {
        const double scale = c == PhaseElement::L ? scale_[c] * element.J() : scale_[c];
        most = std::max(most, bump * std::fabs(now_.defect[c]) / scale);
    }
    return most;
}

bool Collocation::advance() {
    if (++pieces_ > kMostPieces) return false;
    for (; level() < kDeepest; piece_ *= 2) {
        PhaseElement& e = element();
        error_ = solve(e);
        if (!(error_ <= 1)) continue;
        const Piece index = piece_ - std::bit_floor(piece_);
        const double before = static_cast<double>(spans_) * span_;
        from_s_ = origin_s_ + (before + phase(index)) / omega_;
        to_s_ = origin_s_ + (before + phase(index + 1)) / omega_;
        start_ = end_, start_side_ = side_;
        end_ = at(1);
        next_piece();
        return true;
    }
    return false;
}

// The neighbour, or the first of the next span; twice as long where that begins and will do.
void Collocation::next_piece() {
    if (std::has_single_bit(++piece_)) {
        piece_ /= 2, ++spans_, pieces_ = 0;
        if (mirrored_) side_ = -side_;
    }
    const double longer = error_ * (2 << PhaseElement::kStages);
    if (longer < 0.5 && piece_ % 2 == 0 && level() > coarsest_) piece_ /= 2;
}

// The motion at a fraction of the last piece.
BodyState Collocation::at(double x) const {
    constexpr int s = PhaseElement::kStages;
    double v[PhaseElement::count];
    if (x == 1) {
        for (int c = 0; c < PhaseElement::count; ++c) v[c] = now_.stage[c][s - 1];
    } else {
        const auto& rule = PhaseElement::Rule::get();
        const auto weight = rule.dense(x);
        const double bump = rule.bump(x);
        for (int c = 0; c < PhaseElement::count; ++c) {
            v[c] = now_.start[c] - bump * now_.defect[c];
            for (int k = 0; k < s; ++k) v[c] += weight[k] * (now_.stage[c][k] - now_.start[c]);
        }
    }
    const double side = start_side_, c = std::cos(start_.theta), n = std::sin(start_.theta);
    const double px = v[PhaseElement::x], py = side * v[PhaseElement::y];
    return {start_.x + c * px - n * py,
            start_.y + n * px + c * py,
            start_.theta + side * v[PhaseElement::angle],
            v[PhaseElement::Vx],
            side * v[PhaseElement::Vy],
            side * v[PhaseElement::L]};
}

StepOutcome Collocation::step(double t_limit) {
    if (t_ >= to_s_ && !advance())
        return {false, "rounding hides its error, or the chain spins too fast for its gait"};
    t_ = std::min(to_s_, t_limit), fresh_ = false;
    return {};
}

const double* Collocation::state() const {
    if (!fresh_) dense(t_, y_.data());
    fresh_ = true;
    return y_.data();
}

void Collocation::dense(double t, double* y) const {
    const double x = t >= to_s_ ? 1 : (t - from_s_) / (to_s_ - from_s_);
    shape_.set(robot_, table_, std::sin(omega_ * t), std::cos(omega_ * t), false);
    TailFrame(shape_).tail(x == 1 ? end_ : at(x), omega_, y);
}

}  // namespace serpenoid
