// Margins and their roots of event_finder.hpp.
#include "periodic/pieces/event_finder.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/bracketed_root.hpp"

namespace serpenoid {

namespace {

constexpr int kStages = SlidingPiece::kStages;
using Rule = SlidingPiece::Rule;
using Polynomial = StagePolynomial<kStages>;

// Margins that end a mode: at a stage, and between stages, where the polynomial is less accurate.
// What lies between these and the aim is rounding.
constexpr double kBeyond = -2;
constexpr double kFarBeyond = -40;

}  // namespace

void EventFinder::set_margins(const SlidingMode& mode) {
    piece_.speeds(margin_.data());
    for (int wheel = 0; wheel < wheels_; ++wheel) {
        const double unit = mode.sign[wheel] / speed_eps_;
        for (double& m : margin_[wheel].value) m *= unit;
    }
    for (int a = 0; a < mode.count; ++a) {
        const int wheel = mode.stuck[a];
        const double unit = piece_.breakaway_ratio(wheel) / force_eps_,
                     bound = piece_.law(wheel).bound();
        const double side = std::copysign(1 / bound, piece_.stage_force(kStages - 1, a));
        for (int j = 0; j <= kStages; ++j) {
            const double f = j == 0 ? piece_.stuck_force(a, 0) : piece_.stage_force(j - 1, a);
            margin_[wheel].value[j] = unit * (1 - side * f);
        }
    }
}

// The first end of a wheel's mode before `limit`: between the first pair of points of which the
// second is beyond it, or in a dip between them. A fraction of the piece, or `limit`.
double EventFinder::end_of_wheel(const double* m, double limit) const {
    constexpr double kRootError = 0.1;      // of a margin
    constexpr double kShortest = 1.0 / 64;  // of a piece: a dip's width
    const auto& c = Rule::get().c;
    const Polynomial p(m);
    const auto crossing = [&](double start, double margin, double end, double end_margin) {
        if (margin <= -1) return start;
        return bracketed_root([&](double x) { return p(x) + 1; }, start, margin + 1, end,
                              end_margin + 1, kRootError);
    };
    double first = limit, z = 0;
    for (int j = 0; j < kStages && z < first; z = c[j++])
        if (m[j + 1] < kBeyond) first = std::min(first, crossing(z, m[j], c[j], m[j + 1]));
    Stretch<kStages> stretch{0, 1, p.bernstein()}, dip;
    if (first < 1) stretch = stretch.cut(first);
    if (stretch.first_below(kFarBeyond, kShortest, dip))
        first = std::min(first, crossing(dip.start, dip.b[0], dip.end, dip.b[kStages]));
    return first;
}

// The first end of rest: at the bound on the side of the piece's end, or at the other one, which is
// looked for only where the force changes its sign.
double EventFinder::end_of_rest(int wheel, double limit) const {
    const double* m = margin_[wheel].value;
    const double between_bounds = 2 * piece_.breakaway_ratio(wheel) / force_eps_;
    const double end = lowest_[wheel] < kBeyond ? end_of_wheel(m, limit) : limit;
    if (*std::max_element(m, m + kStages + 1) <= between_bounds / 2) return end;
    Lanes mirrored{};
    for (int j = 0; j <= kStages; ++j) mirrored.value[j] = between_bounds - m[j];
    return end_of_wheel(mirrored.value, end);
}

// Where a sliding wheel really stops: over a long piece its speed is no polynomial.
double EventFinder::sharpen(int wheel, double sign, double x) {
    constexpr double kCloseMargin = 0.5;  // from the one that is aimed at
    constexpr double kMaxMove = 0.01;     // of a piece: beyond it the slope is not that of the root
    const Polynomial p(margin_[wheel].value);
    for (int i = 0; i < 3; ++i) {
        const double miss = sign * piece_.speed(wheel, x) / speed_eps_ + 1;
        const double move = -miss / p.slope(x);
        if (std::fabs(miss) < kCloseMargin || !(std::fabs(move) < kMaxMove)) break;
        x = std::clamp(x + move, 0.0, 1.0);
    }
    return x;
}

ModeEvent EventFinder::first_event(const SlidingMode& mode, double h) {
    set_margins(mode);
    piece_.lowest(margin_.data(), lowest_.data());
    ModeEvent event;
    for (int wheel = 0; wheel < wheels_; ++wheel) {
        if (!piece_.law(wheel).has_modes()) continue;
        const bool rests = mode.sign[wheel] == 0;
        if (!rests && lowest_[wheel] >= kBeyond) continue;
        const double end = rests ? end_of_rest(wheel, event.fraction)
                                 : end_of_wheel(margin_[wheel].value, event.fraction);
        if (end < event.fraction) event = {end, wheel, mode.sign[wheel] != 0};
    }
    if (!event.sliding) return event;
    if (event.fraction > 0)
        event.fraction = sharpen(event.wheel, mode.sign[event.wheel], event.fraction);
    event.slope = Polynomial(margin_[event.wheel].value).slope(event.fraction) * speed_eps_ / h;
    return event;
}

}  // namespace serpenoid
