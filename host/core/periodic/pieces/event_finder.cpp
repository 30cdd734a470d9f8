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
constexpr double kBeyond = -2, kFarBeyond = -40;

}  // namespace

void EventFinder::set_margins(const SlidingMode& mode) {
    piece_.speeds(margin_.data());
    for (int wheel = 0; wheel < wheels_; ++wheel) {
        const double unit = mode.sign[wheel] / speed_eps_;
        for (double& m : margin_[wheel].at) m *= unit;
    }
    for (int a = 0; a < mode.count; ++a) {
        const int wheel = mode.stuck[a];
        const double unit = piece_.grip(wheel) / force_eps_, bound = piece_.law(wheel).bound;
        const double side = std::copysign(1 / bound, piece_.stage_force(kStages - 1, a));
        for (int j = 0; j <= kStages; ++j) {
            const double f = j == 0 ? piece_.stuck_force(a, 0) : piece_.stage_force(j - 1, a);
            margin_[wheel].at[j] = unit * (1 - side * f);
        }
    }
}

// The first end of a wheel's mode before `first`: between the first pair of points of which the
// second is beyond it, or in a dip between them. A fraction of the piece, or `first`.
double EventFinder::end_of_wheel(const double* m, double first) const {
    const auto& c = Rule::get().c;
    const Polynomial p(m);
    const auto between = [&](double z, double before, double end, double value) {
        constexpr double kNear = 0.1;
        if (before <= -1) return z;
        return bracketed_root([&](double x) { return p(x) + 1; }, z, before + 1, end, value + 1,
                              kNear);
    };
    double found = first, z = 0;
    for (int j = 0; j < kStages && z < found; z = c[j++])
        if (m[j + 1] < kBeyond) found = std::min(found, between(z, m[j], c[j], m[j + 1]));
    Stretch<kStages> whole{0, 1, p.bernstein()}, dip;
    if (found < 1) whole = whole.cut(found);
    if (whole.first_below(kFarBeyond, 1.0 / 64, dip))
        found = std::min(found, between(dip.from, dip.b[0], dip.to, dip.b[kStages]));
    return found;
}

// The first end of rest: at the bound on the side of the piece's end, or at the other one, which is
// looked for only where the force changes its sign.
double EventFinder::end_of_rest(int wheel, double first) const {
    const double* m = margin_[wheel].at;
    const double far = 2 * piece_.grip(wheel) / force_eps_;  // from one bound to the other
    const double end = lowest_[wheel] < kBeyond ? end_of_wheel(m, first) : first;
    if (*std::max_element(m, m + kStages + 1) <= far / 2) return end;
    Lanes other{};
    for (int j = 0; j <= kStages; ++j) other.at[j] = far - m[j];
    return end_of_wheel(other.at, end);
}

// Where a sliding wheel really stops: over a long piece its speed is no polynomial.
double EventFinder::sharpen(int wheel, double sign, double x) {
    const Polynomial p(margin_[wheel].at);
    for (int i = 0; i < 3; ++i) {
        const double off = sign * piece_.speed(wheel, x) / speed_eps_ + 1;
        const double moved = -off / p.slope(x);
        if (std::fabs(off) < 0.5 || !(std::fabs(moved) < 0.01)) break;
        x = std::clamp(x + moved, 0.0, 1.0);
    }
    return x;
}

ModeEvent EventFinder::first(const SlidingMode& mode, double h) {
    set_margins(mode);
    piece_.lowest(margin_.data(), lowest_.data());
    ModeEvent first;
    for (int wheel = 0; wheel < wheels_; ++wheel) {
        if (!piece_.law(wheel).has_modes()) continue;
        const bool rests = mode.sign[wheel] == 0;
        if (!rests && lowest_[wheel] >= kBeyond) continue;
        const double at =
            rests ? end_of_rest(wheel, first.at) : end_of_wheel(margin_[wheel].at, first.at);
        if (at < first.at) first = {at, wheel, mode.sign[wheel] != 0};
    }
    if (!first.sliding) return first;
    if (first.at > 0) first.at = sharpen(first.wheel, mode.sign[first.wheel], first.at);
    first.slope = Polynomial(margin_[first.wheel].at).slope(first.at) * speed_eps_ / h;
    return first;
}

}  // namespace serpenoid
