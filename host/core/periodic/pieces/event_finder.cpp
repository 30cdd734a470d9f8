// Margins of the wheels and their roots, for event_finder.hpp.
#include "periodic/pieces/event_finder.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/bracketed_root.hpp"

namespace serpenoid {

namespace {

constexpr int kStages = SlidingPiece::kStages;
using Rule = SlidingPiece::Rule;
using Polynomial = StagePolynomial<kStages>;

// How the end of a mode is found; held by random states of other code
// (tests/host/periodic/test_random_truth.py).
struct EventTuning {
    // Margins below which a mode has ended. Values between these and -1 may be rounding; between
    // stages the polynomial is less accurate.
    double margin_at_stage = -2;
    double margin_between_stages = -40;
    double root_error = 0.1;          // error of the margin at the root
    double min_dip_width = 1.0 / 64;  // width of a dip, as a fraction of a piece
    double margin_error = 0.5;        // accepted distance of a refined stop from the margin -1
    double max_move = 0.01;  // fraction of a piece by which a stop is refined; farther off the
                             // slope differs
};
constexpr EventTuning kEvent;

}  // namespace

void EventFinder::set_margins(const SlidingMode& mode) {
    piece_.speeds(margin_.data());
    for (int wheel = 0; wheel < wheels_; ++wheel) {
        const double unit = mode.sign[wheel] / speed_eps_;
        for (double& margin : margin_[wheel].value) margin *= unit;
    }
    for (int a = 0; a < mode.count; ++a) {
        const int wheel = mode.stuck[a];
        const double unit = piece_.breakaway_ratio(wheel) / force_eps_;
        const double inverse_bound =
            std::copysign(1 / piece_.law(wheel).bound(), piece_.stage_force(kStages - 1, a));
        for (int j = 0; j <= kStages; ++j) {
            const double force = j == 0 ? piece_.stuck_force(a, 0) : piece_.stage_force(j - 1, a);
            margin_[wheel].value[j] = unit * (1 - inverse_bound * force);
        }
    }
}

// The fraction of the piece at which a wheel's mode ends first, or `limit` if it lasts until then.
// The end lies before the first stage whose margin is too low, or in a dip between two stages.
double EventFinder::end_of_wheel(const double* m, double limit) const {
    const auto& c = Rule::get().c;
    const Polynomial p(m);
    const auto crossing = [&](double start, double margin, double end, double end_margin) {
        if (margin <= -1) return start;
        return bracketed_root([&](double x) { return p(x) + 1; }, start, margin + 1, end,
                              end_margin + 1, kEvent.root_error);
    };
    double first = limit, start = 0;
    for (int j = 0; j < kStages && start < first; ++j) {
        if (m[j + 1] < kEvent.margin_at_stage)
            first = std::min(first, crossing(start, m[j], c[j], m[j + 1]));
        start = c[j];
    }
    BernsteinInterval<kStages> searched{0, 1, p.bernstein()}, dip;
    if (first < 1) searched = searched.split(first);
    if (searched.first_below(kEvent.margin_between_stages, kEvent.min_dip_width, dip))
        first = std::min(first, crossing(dip.start, dip.b[0], dip.end, dip.b[kStages]));
    return first;
}

// The fraction of the piece at which a wheel's rest ends first: at the bound from which its margin
// is taken, or at the opposite one, which is examined only if the force changes its sign.
double EventFinder::end_of_rest(int wheel, double limit) const {
    const double* m = margin_[wheel].value;
    const double between_bounds = 2 * piece_.breakaway_ratio(wheel) / force_eps_;
    const double end =
        lower_bound_[wheel] < kEvent.margin_at_stage ? end_of_wheel(m, limit) : limit;
    if (*std::max_element(m, m + kStages + 1) <= between_bounds / 2) return end;
    Lanes mirrored{};
    for (int j = 0; j <= kStages; ++j) mirrored.value[j] = between_bounds - m[j];
    return end_of_wheel(mirrored.value, end);
}

// The fraction of the piece at which the speed of a sliding wheel has the margin -1, starting from
// x, the root of the polynomial: over a long piece the polynomial through the stages is inaccurate.
double EventFinder::refine_stop(int wheel, double sign, double x) {
    const Polynomial p(margin_[wheel].value);
    for (int i = 0; i < 3; ++i) {
        const double error = sign * piece_.speed(wheel, x) / speed_eps_ + 1;
        const double move = -error / p.slope(x);
        if (std::fabs(error) < kEvent.margin_error || !(std::fabs(move) < kEvent.max_move)) break;
        x = std::clamp(x + move, 0.0, 1.0);
    }
    return x;
}

ModeEvent EventFinder::first_event(const SlidingMode& mode, double h) {
    set_margins(mode);
    piece_.lower_bounds(margin_.data(), lower_bound_.data());
    ModeEvent event;
    for (int wheel = 0; wheel < wheels_; ++wheel) {
        if (!piece_.law(wheel).has_modes()) continue;
        const bool rests = mode.sign[wheel] == 0;
        if (!rests && lower_bound_[wheel] >= kEvent.margin_at_stage) continue;
        const double end = rests ? end_of_rest(wheel, event.fraction)
                                 : end_of_wheel(margin_[wheel].value, event.fraction);
        if (end < event.fraction) event = {end, wheel, mode.sign[wheel] != 0};
    }
    if (!event.sliding) return event;
    if (event.fraction > 0)
        event.fraction = refine_stop(event.wheel, mode.sign[event.wheel], event.fraction);
    event.slope = Polynomial(margin_[event.wheel].value).slope(event.fraction) * speed_eps_ / h;
    return event;
}

}  // namespace serpenoid
