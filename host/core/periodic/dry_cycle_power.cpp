// What the joints do over a piece of dry_cycle.hpp: the integrals of their positive powers.
#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/gauss_rule.hpp"
#include "periodic/dry_cycle.hpp"
#include "periodic/positive_power.hpp"

namespace serpenoid {

// Add the work of a kick as of the powers at the start of the piece that follows it.
void DryCycle::add_kick_work() {
    const double start = 0;
    piece_.torques(1, &start, torque_.data(), rate_.data());
    for (int i = 0; i + 1 < robot_.n; ++i) {
        const double work = -skipped_ / omega_ * torque_[i].at[0] * rate_[i].at[0];
        net_work_ += work, (*positive_)[i] += std::max(work, 0.0);
    }
}

// Add the integrals of P_i^+ over the first x of a piece. It is drawn out backwards over the kick
// before it, but where the kick was not much shorter its polynomial does not reach so far. Torques
// are no polynomials: however long the motion lets a piece be, they are taken at Gauss points of
// shorter parts.
void DryCycle::add_positive(double tau, double h, double x) {
    constexpr double kFarthest = 0.1;  // of the part that is used
    constexpr double kLongest = 0.25;  // rad
    const bool drawn = skipped_ <= kFarthest * h * x;
    if (!drawn) add_kick_work();
    const double start = drawn ? -skipped_ / h : 0;
    const int parts = static_cast<int>(std::ceil(h * (x - start) / kLongest));
    for (int k = 0; k < parts; ++k)
        add_part(tau, h, start + (x - start) * k / parts, (x - start) / parts);
    add_doubt(h, x);
}

// A wheel whose speed dips to nearly nothing may rest there or not, for all that the motion tells
// at this tolerance: its force, and those of wheels that rest, are then in doubt by as much as its
// dry friction, for as long as it is so slow. The speeds hardly feel it, as the wheel has none. One
// that has just begun to slide is slow as well, and without doubt.
void DryCycle::add_doubt(double h, double x) {
    constexpr double kSlow = 20;  // a fifth of a tolerance of speed, in units of the aim
    constexpr double kFinest = 1e-7;
    const double reach = 2 * robot_.l * alpha_ * robot_.n / 4;  // of the force, m
    for (int wheel = 0; wheel < 2 * robot_.n; ++wheel) {
        if (mode_.sign[wheel] == 0 || piece_.mu(wheel) == 0) continue;
        if (lowest_[wheel] >= kSlow) {
            fresh_[wheel] = 0;
            continue;
        }
        const StagePolynomial<SlidingPiece::kStages> p(margin_[wheel].at);
        Stretch<SlidingPiece::kStages> whole{0, 1, p.bernstein()};
        if (x < 1) whole = whole.cut(x);
        if (!fresh_[wheel])
            doubtful_work_ += piece_.mu(wheel) * reach * h * whole.below(kSlow, kFinest);
        if (p(x) >= kSlow) fresh_[wheel] = 0;
    }
}

// The same between two fractions of a piece, `wide` apart.
void DryCycle::add_part(double tau, double h, double from, double wide) {
    constexpr int g = 5;
    const double span = h * wide;
    const Gauss<g>& rule = Gauss<g>::get();
    double x_of[g];
    for (int q = 0; q < g; ++q) x_of[q] = from + wide * rule.c[q];
    piece_.torques(g, x_of, torque_.data(), rate_.data());
    for (int i = 0; i + 1 < robot_.n; ++i) {
        std::array<double, g> torque, rate;
        for (int q = 0; q < g; ++q) {
            torque[q] = torque_[i].at[q], rate[q] = rate_[i].at[q];
            net_work_ -= span / omega_ * rule.b[q] * torque[q] * rate[q];
        }
        (*positive_)[i] +=
            span / omega_ *
            mean_positive_swing<g>(torque, rate, tau + from * h, span, lag_[i], alpha_);
    }
}

}  // namespace serpenoid
