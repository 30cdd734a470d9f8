// Parts and doubts of work_meter.hpp.
#include "periodic/pieces/work_meter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/gauss_rule.hpp"
#include "periodic/pieces/mean_positive_swing.hpp"

namespace serpenoid {

WorkMeter::WorkMeter(const Robot& robot, const Gait& gait, SlidingPiece& piece,
                     const EventFinder& events)
    : alpha_(gait.alpha),
      omega_(gait.omega),
      reach_(2 * robot.l * gait.alpha * robot.n / 4),
      piece_(piece),
      events_(events),
      torque_(robot.n),
      rate_(robot.n),
      fresh_(2 * robot.n) {
    const GaitTable table(robot.n, gait);
    for (int i = 0; i + 1 < robot.n; ++i) lag_.push_back(table.lag(i));
}

void WorkMeter::start(bool wanted, double tolerance) {
    // of the Gauss points; on smooth ground kinks of P_i^+ alone limit it
    const double order = piece_.has_modes() ? 12 : 6;
    wanted_ = wanted;
    longest_ = std::clamp(0.3 * std::pow(tolerance / 6e-7, 1 / order), 0.01, 0.5);
    work_.net = work_.doubtful = 0;
    work_.positive.assign(wanted ? lag_.size() : 0, 0.0);
    std::fill(fresh_.begin(), fresh_.end(), 0);
}

// Event steps work as the joints do at the start of the piece that follows them.
void WorkMeter::add_event_steps(double skipped) {
    const double start = 0;
    piece_.torques(1, &start, torque_.data(), rate_.data());
    for (std::size_t i = 0; i < lag_.size(); ++i) {
        const double work = -skipped / omega_ * torque_[i].at[0] * rate_[i].at[0];
        work_.net += work, work_.positive[i] += std::max(work, 0.0);
    }
}

// The piece is extrapolated backwards over the event steps before it; if they are long they count
// by themselves. Torques are no polynomials: they are taken at Gauss points of short parts.
void WorkMeter::add(const SlidingMode& mode, double tau, double h, double x, double skipped) {
    constexpr double kFarthest = 0.1;  // of the part that is used
    if (!wanted_) return;
    const bool extended = skipped <= kFarthest * h * x;
    if (!extended) add_event_steps(skipped);
    const double start = extended ? -skipped / h : 0;
    const int parts = static_cast<int>(std::ceil(h * (x - start) / longest_));
    for (int k = 0; k < parts; ++k)
        add_part(tau, h, start + (x - start) * k / parts, (x - start) / parts);
    add_doubt(mode, h, x);
}

// A wheel whose speed dips close to zero may rest there or not: the mode is ambiguous at this
// tolerance. While it is so slow, its force and those of wheels at rest are uncertain by its dry
// friction; the speeds hardly change. A wheel that has just begun to slide is slow, too, but its
// mode is certain.
void WorkMeter::add_doubt(const SlidingMode& mode, double h, double x) {
    constexpr double kSlow = 20;  // a fifth of a tolerance of speed, in units of the aim
    constexpr double kFinest = 1e-7;
    for (int wheel = 0; wheel < piece_.wheels(); ++wheel) {
        if (mode.sign[wheel] == 0 || piece_.law(wheel).bound == 0) continue;
        if (events_.lowest(wheel) >= kSlow) {
            fresh_[wheel] = 0;
            continue;
        }
        const StagePolynomial<SlidingPiece::kStages> p(events_.margins(wheel));
        if (!fresh_[wheel]) {
            Stretch<SlidingPiece::kStages> whole{0, 1, p.bernstein()};
            if (x < 1) whole = whole.cut(x);
            work_.doubtful += piece_.law(wheel).bound * reach_ * h * whole.below(kSlow, kFinest);
        }
        if (p(x) >= kSlow) fresh_[wheel] = 0;
    }
}

// The integrals between two fractions of a piece, `wide` apart.
void WorkMeter::add_part(double tau, double h, double from, double wide) {
    constexpr int g = 6;
    const double span = h * wide;
    const Gauss<g>& rule = Gauss<g>::get();
    double x_of[g];
    for (int q = 0; q < g; ++q) x_of[q] = from + wide * rule.c[q];
    piece_.torques(g, x_of, torque_.data(), rate_.data());
    for (std::size_t i = 0; i < lag_.size(); ++i) {
        std::array<double, g> torque, rate;
        for (int q = 0; q < g; ++q) {
            torque[q] = torque_[i].at[q], rate[q] = rate_[i].at[q];
            work_.net -= span / omega_ * rule.b[q] * torque[q] * rate[q];
        }
        work_.positive[i] +=
            span / omega_ *
            mean_positive_swing<g>(torque, rate, tau + from * h, span, lag_[i], alpha_);
    }
}

}  // namespace serpenoid
