// Levels and errors of refinement.hpp.
#include "periodic/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numerics/matrix_product.hpp"

namespace serpenoid {

namespace {

constexpr double kEarlier = 0.05;  // of the change before: one change may be small by luck

constexpr double kLeastSettling = 4;  // levels may agree by luck
constexpr double kRounding = 1e-15;   // of a map on smooth ground, over the scales
constexpr double kTwice = 2;          // smooth ground: a change may be a part of the error alone
constexpr double kKinks = 0.3;        // the same for power on smooth ground

// The derivative over a period in (Vx, Vy, L), of that of the image by p.
Mat3 monodromy_of(Mat3 M, const CycleMap& map) {
    for (int i = 0; i < 2; ++i) M[3 * i + 2] /= map.nm(), M[6 + i] *= map.nm();
    return map.mirrored() ? multiply(M, M) : M;
}

Vec3 times(const Vec3& a, const Vec3& b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2]}; }

}  // namespace

// Speed, turn and power of the orbit's own start: those of the motion that was followed, and what
// Newton's last step changes by derivatives.
SteadyState Refinement::report(const Orbit& orbit, double tolerance) const {
    const Vec3 &scale = map_.scale(), p = times(orbit.start(), scale);
    const CycleState& end = orbit.end.state;
    const auto value = [&](double v, int row) { return orbit.at_start(v, row, scale); };
    Path path{value(end.x, CycleState::kX), value(end.y, CycleState::kY),
              value(end.theta, CycleState::kTheta)};
    const double period = 2 * std::numbers::pi / map_.gait().omega;
    SteadyState out;
    Mat3 M = orbit.derivative;
    for (int i = 0; i < 9; ++i) M[i] *= scale[i / 3] / scale[i % 3];
    out.monodromy = monodromy_of(M, map_), out.slowest = log_spectral_radius(out.monodromy);
    if (map_.mirrored()) path = path.twice_mirrored();
    out.chord = path.length() / period, out.turn = path.turn;
    if (!map_.mirrored()) {
        const auto arc = map_.follow(p, {tolerance, false, path.turn / (2 * std::numbers::pi)});
        if (arc) path = {arc->state.x, arc->state.y, path.turn};
    }
    out.speed = path.length() / period, out.direction = path.direction();
    out.power = value(end.dissipated, CycleState::kDissipated) / map_.time();
    out.start = {p[0] / map_.nm(), p[1] / map_.nm(), map_.rate(p[2])};
    return out;
}

// Sums over the joints. Every joint's change from the level before counts as an error, and so does
// the mismatch of the joints' net work and what friction took.
void Refinement::add_positive(const JointWork& work, double mismatch, SteadyState& next) {
    double change = work.error + mismatch;
    positive_.resize(work.positive.size());
    for (std::size_t i = 0; i < positive_.size(); ++i) {
        next.positive_power += work.positive[i] / map_.time();
        change += std::fabs(work.positive[i] - positive_[i]);
    }
    next.positive_power_error = change / map_.time();
    next.abs_power = 2 * next.positive_power - next.power;
    positive_ = work.positive;
}

// Error of a level: its change from the level before, and the effects of the start's change and of
// the map's error. One change alone may be small by luck.
void Refinement::bound(const Orbit& orbit, double tolerance, SteadyState& next) {
    constexpr double kState = 0.8;
    constexpr double kLuck = 0.15;  // a power seldom changes by less than this of a tolerance
    const Vec3 &scale = map_.scale(), z = orbit.start();
    double moved = 0;
    for (int k = 0; k < 3; ++k) moved = std::max(moved, std::fabs(z[k] - z_[k]));
    z_ = z;
    // smooth pieces gain so much from a level to the next that its change tells all but rounding
    const bool smooth = map_.smooth();
    const double by_map = smooth ? kRounding : tolerance;
    const double state = kState * ((smooth ? kTwice : 1) * moved + by_map * orbit.condition());
    const double by_state = state * orbit.sensitivity(CycleState::kDissipated, scale) / map_.time();
    // where wheels hardly roll back, coarse levels say little about the power
    const double earlier = smooth ? kKinks : kEarlier;
    ErrorRule rule{smooth ? kTwice : 1, earlier, state * scale[0] / map_.nm(),
                   kLuck * by_map * next.power + by_state,
                   kLuck * by_map + state * orbit.sensitivity(CycleState::kTheta, scale)};
    if (options_.powers) {
        const double mismatch = std::fabs(orbit.end.work.net - orbit.end.state.dissipated);
        add_positive(orbit.end.work, mismatch, next);
        rule.power += mismatch / map_.time();
        next.positive_power_error += by_state;
    }
    const LevelChange change(next, coarse_);
    bound_errors(change, before_, rule, options_.rtol, next);
    // derivatives jump where the sequence of modes does: one change tells little of the next
    next.slowest_error = std::max(5 * change.slowest + (smooth ? 1 : 0.3) * before_.slowest,
                                  kLeastSettling * options_.rtol * std::fabs(next.slowest));
    if (orbit.end.simultaneous_events)
        next.slowest_error = std::max(next.slowest_error, std::fabs(next.slowest));
}

FixedPoint::Ended Refinement::level(double tolerance, const Levels& levels, SteadyState& next) {
    constexpr double kFirst = 2.0 / 3;  // of the goal, while the start is not good to a tolerance
    constexpr double kLeast = 1e-9;
    constexpr double kRough = 0.005;  // its square is what a rough speed may be off by
    const double longest =
        std::max(levels.goal * tolerance, levels.root_goal * std::sqrt(tolerance));
    const double goal =
        options_.rough ? kRough : std::max((point_.near ? 1 : kFirst) * longest, kLeast);
    Orbit orbit;
    const auto ended = point_.solve(tolerance, goal, options_.powers, orbit);
    if (ended != FixedPoint::Ended::converged) return ended;
    next = report(orbit, tolerance);
    next.iterations = point_.iterations;
    point_.near = true;
    bound(orbit, tolerance, next);
    return ended;
}

// A level that breaks off at one tolerance mostly succeeds at another, so it has several tries.
SteadyState Refinement::refine(const Levels& levels, const Acceptance& accepted) {
    constexpr int kTries = 3;
    SteadyState best = SteadyState::unknown();
    z_ = point_.z, point_.near = false;
    int broken = 0;
    for (double tolerance = levels.first; tolerance > levels.last; tolerance *= levels.tighter) {
        SteadyState next;
        const auto ended = level(tolerance, levels, next);
        if (ended != FixedPoint::Ended::converged) {
            if (++broken == kTries) break;
            if (point_.near || ended == FixedPoint::Ended::broken) point_.z = z_;
            tolerance *= 10;  // half of this one comes next
            continue;
        }
        if (options_.rough) {
            next.converged = true;
            return next;
        }
        next.converged = !first_ && accepted(next);
        if (first_ || accepted.excess(next) < accepted.excess(best)) best = next;
        if (next.converged) break;
        if (!first_) before_ = LevelChange(next, coarse_);
        coarse_ = next, first_ = false;
    }
    return best;
}

}  // namespace serpenoid
