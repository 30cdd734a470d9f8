// Levels and errors of refinement.hpp.
#include "periodic/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numerics/matrix_product.hpp"

namespace serpenoid {

namespace {

// What an error is stated as, by the changes from level to level. Held by random states of other
// code (tests/host/periodic/test_random_truth.py); smooth pieces gain so much from a level to the
// next that its change tells all but rounding.
struct ErrorWeights {
    double change;            // of the last change: on smooth ground it may be half of the error
    double last_change;       // of the change before: one may be small by luck
    double last_multiplier;   // the same of the multiplier's logarithm
    double multiplier = 5;    // of its last change: derivatives jump where the modes do
    double state = 0.8;       // of the start's change and the map's error
    double luck = 0.15;       // a power seldom changes by less than this of a tolerance
    double rounding = 1e-15;  // of a map on smooth ground, over the scales
    double turn = 1e-14;      // rad, least error
    double settling = 4;      // least error of the multiplier's logarithm, over what is asked
};
constexpr ErrorWeights kSmoothErrors{2, 0.3, 1}, kDryErrors{1, 0.05, 0.3};

// Tolerances of the levels, and Newton's last step on each. Exact derivatives stand for that step,
// and miss its square.
struct Levels {
    double tolerances = 60;       // of the last step
    double roots = 0.7;           // of a tolerance, the same on dry ground where that is longer
    double first_goal = 2.0 / 3;  // of the goal, while the start is not good to a tolerance
    double min_goal = 1e-9;
    double rough_goal = 0.005;  // its square is what a rough speed may be off by
    double tighter = 0.05;      // a tolerance over the one before
    double tightest = 1e-13;
    double first_smooth = 1e-6;  // on smooth ground even a loose level costs as much
    int tries = 3;               // levels that may break off
};
constexpr Levels kLevels;

// The derivative over a period in (Vx, Vy, L), of that of the image by p.
Mat3 monodromy_of(Mat3 M, const CycleMap& map) {
    for (int i = 0; i < 2; ++i) {
        M[3 * i + 2] /= map.nm();
        M[6 + i] *= map.nm();
    }
    return map.mirrored() ? multiply(M, M) : M;
}

Vec3 times(const Vec3& a, const Vec3& b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2]}; }

}  // namespace

// Speed, turn and power of the orbit's next start: those of the motion that was followed, and what
// Newton's last step changes by derivatives. Nothing where the cycle that tells the speed of a gait
// that turns breaks off.
std::optional<SteadyState> Refinement::report(const Orbit& orbit, double tolerance) const {
    const Vec3 &scale = map_.scale(), p = times(orbit.next_start(), scale);
    const CycleState& end = orbit.end.state;
    const auto value = [&](double v, int row) { return orbit.extrapolate(v, row, scale); };
    Path path{value(end.x, CycleState::kX), value(end.y, CycleState::kY),
              value(end.theta, CycleState::kTheta)};
    const double period = 2 * std::numbers::pi / map_.gait().omega;
    SteadyState state;
    Mat3 M = orbit.derivative;
    for (int i = 0; i < 9; ++i) M[i] *= scale[i / 3] / scale[i % 3];
    state.monodromy = monodromy_of(M, map_);
    state.log_largest_multiplier = log_spectral_radius(state.monodromy);
    if (map_.mirrored()) path = path.twice_mirrored();
    state.chord = path.length() / period;
    state.turn = path.turn;
    if (!map_.mirrored()) {
        const auto arc = map_.follow(p, {tolerance, false, path.turn / (2 * std::numbers::pi)});
        if (!arc) return {};
        path = {arc->state.x, arc->state.y, path.turn};
    }
    state.speed = path.length() / period;
    state.direction = path.direction();
    state.power = value(end.dissipated, CycleState::kDissipated) / map_.time();
    state.start = {p[0] / map_.nm(), p[1] / map_.nm(), map_.rate(p[2])};
    return state;
}

// Sums over the joints. Every joint's change from the level before counts as an error.
void Refinement::add_positive(const JointWork& work, double remainder, SteadyState& next) {
    double change = work.error;
    positive_.resize(work.positive.size());
    for (std::size_t i = 0; i < positive_.size(); ++i) {
        next.positive_power += work.positive[i] / map_.time();
        change += std::fabs(work.positive[i] - positive_[i]);
    }
    next.positive_power_error =
        stated_error(change / map_.time() + remainder, options_.rtol, next.positive_power);
    next.abs_power = 2 * next.positive_power - next.power;
    positive_ = work.positive;
}

// Error of a level: its change from the level before, and the effects of the start's change and of
// the map's error.
void Refinement::state_errors(const Orbit& orbit, double tolerance, SteadyState& next) {
    const bool smooth = map_.smooth();
    const ErrorWeights& weights = smooth ? kSmoothErrors : kDryErrors;
    const double by_map = smooth ? weights.rounding : tolerance;
    const Vec3 &scale = map_.scale(), start = orbit.next_start();
    double moved = 0;
    for (int k = 0; k < 3; ++k) moved = std::max(moved, std::fabs(start[k] - last_start_[k]));
    last_start_ = start;
    const double state = weights.state * (weights.change * moved + by_map * orbit.condition());
    const double watts = state * orbit.sensitivity(CycleState::kDissipated, scale) / map_.time();
    double mismatch = 0;  // W, of the joints' net work and what friction took
    if (options_.powers) {
        mismatch = std::fabs(orbit.end.work.net - orbit.end.state.dissipated) / map_.time();
        add_positive(orbit.end.work, mismatch + watts, next);
    }
    const Change change{
        std::fabs(next.speed - coarse_.speed), std::fabs(next.power - coarse_.power),
        std::fabs(next.turn - coarse_.turn),
        // logarithms, either of which may be that of zero
        next.log_largest_multiplier == coarse_.log_largest_multiplier
            ? 0
            : std::fabs(next.log_largest_multiplier - coarse_.log_largest_multiplier)};
    const auto error = [&](double Change::* field, double remainder, double value) {
        const double sum =
            weights.change * change.*field + weights.last_change * last_change_.*field + remainder;
        return stated_error(sum, options_.rtol, value);
    };
    next.speed_error = error(&Change::speed, state * scale[0] / map_.nm(), next.speed);
    next.power_error =
        error(&Change::power, weights.luck * by_map * next.power + watts + mismatch, next.power);
    const double radians =
        weights.luck * by_map + state * orbit.sensitivity(CycleState::kTheta, scale);
    next.turn_error = std::max(error(&Change::turn, radians, next.turn), weights.turn);
    next.log_multiplier_error =
        std::max(weights.multiplier * change.log_largest_multiplier +
                     weights.last_multiplier * last_change_.log_largest_multiplier,
                 weights.settling * options_.rtol * std::fabs(next.log_largest_multiplier));
    if (orbit.end.simultaneous_events)
        next.log_multiplier_error =
            std::max(next.log_multiplier_error, std::fabs(next.log_largest_multiplier));
    last_change_ = first_ ? Change{} : change;
}

// Newton's last step is as long as so many tolerances, or as their square root where that is
// longer; smooth pieces are too accurate for that.
FixedPoint::Ended Refinement::level(double tolerance, SteadyState& next) {
    const double root = map_.smooth() ? 0 : kLevels.roots * std::sqrt(tolerance);
    const double longest = std::max(kLevels.tolerances * tolerance, root);
    const double goal =
        options_.rough
            ? kLevels.rough_goal
            : std::max((point_.start_solved ? 1 : kLevels.first_goal) * longest, kLevels.min_goal);
    Orbit orbit;
    const auto ended = point_.solve(tolerance, goal, options_.powers, orbit);
    if (ended != FixedPoint::Ended::converged) return ended;
    const auto reported = report(orbit, tolerance);
    if (!reported) return FixedPoint::Ended::broken;
    next = *reported;
    point_.start_solved = true;
    state_errors(orbit, tolerance, next);
    return ended;
}

// A level that breaks off at one tolerance mostly succeeds at another, so it has several tries.
SteadyState Refinement::refine(double first_tolerance, const Acceptance& accepted) {
    SteadyState best = SteadyState::unknown();
    last_start_ = point_.start;
    point_.start_solved = false;
    double tolerance =
        map_.smooth() ? std::min(first_tolerance, kLevels.first_smooth) : first_tolerance;
    for (int broken = 0; tolerance > kLevels.tightest;) {
        SteadyState next;
        const auto ended = level(tolerance, next);
        if (ended != FixedPoint::Ended::converged) {
            if (++broken == kLevels.tries) break;
            if (point_.start_solved || ended == FixedPoint::Ended::broken)
                point_.start = last_start_;
            tolerance /= 2;
            continue;
        }
        if (options_.rough) {
            next.converged = true;
            return next;
        }
        next.converged = !first_ && accepted(next);
        if (first_ || accepted.excess(next) < accepted.excess(best)) best = next;
        if (next.converged) break;
        coarse_ = next;
        first_ = false;
        tolerance *= kLevels.tighter;
    }
    return best;
}

}  // namespace serpenoid
