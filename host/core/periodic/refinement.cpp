// The levels of refinement.hpp, and the error estimates of their states.
#include "periodic/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numerics/matrix_product.hpp"

namespace serpenoid {

namespace {

// Weights of the changes between levels, and of other terms, in error estimates. Tested against
// random states from other code (tests/host/periodic/test_random_truth.py).
struct ErrorWeights {
    double change;           // weight of the change from the last level
    double last_change;      // weight of the change before it, as one change may be small by chance
    double last_multiplier;  // weight of the change before the last of the multiplier's logarithm
    double multiplier = 5;   // weight of its last change; derivatives jump where modes change
    double state = 0.8;      // weight of the change of the start, and of the map's error
    double power = 0.15;     // least error of a power, relative, over the tolerance
    double rounding = 1e-15;  // error of a map on smooth ground, over the scales
    double turn = 1e-14;      // least error of the turn, rad
    double settling = 4;      // least relative error of the multiplier's logarithm, over rtol
};
constexpr ErrorWeights kSmoothErrors{2, 0.3, 1}, kDryErrors{1, 0.05, 0.3};

// Tolerances of the levels, and the goal for Newton's last step on each. This step is applied by
// derivatives only, with an error of its square.
struct Levels {
    double goal_factor = 60;      // goal over the tolerance
    double root_factor = 0.7;     // goal over the root of the tolerance, if larger, on dry ground
    double first_goal = 2.0 / 3;  // factor on the goal while no start has been solved
    double min_goal = 1e-9;       // least goal, in units of the scales
    double rough_goal = 0.005;    // goal of a rough state, whose speed has an error of its square
    double reduction = 0.05;      // tolerance over that of the last level
    double min_tolerance = 1e-13;
    double first_smooth = 1e-6;  // greatest first tolerance on smooth ground, where it costs little
    int tries = 3;               // number of levels that may fail
};
constexpr Levels kLevels;

// The derivative over a period by (Vx, Vy, L), from the derivative M of the image by p.
Mat3 monodromy_of(Mat3 M, const CycleMap& map) {
    for (int i = 0; i < 2; ++i) {
        M[3 * i + 2] /= map.nm();
        M[6 + i] *= map.nm();
    }
    return map.mirrored() ? multiply(M, M) : M;
}

Vec3 times(const Vec3& a, const Vec3& b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2]}; }

}  // namespace

// The state of the orbit's next start: values of the followed motion, extrapolated over Newton's
// last step by derivatives. A gait that turns needs a further cycle for its speed; if this fails,
// there is no state.
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

// Add the positive power of all joints. Its error contains every joint's change from the last
// level.
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

// Set the error estimates of a level from its change to the last one, from the change of the start,
// and from the error of the map.
void Refinement::state_errors(const Orbit& orbit, double tolerance, SteadyState& next) {
    const bool smooth = map_.smooth();
    const ErrorWeights& weights = smooth ? kSmoothErrors : kDryErrors;
    const double map_error = smooth ? weights.rounding : tolerance;
    const Vec3 &scale = map_.scale(), start = orbit.next_start();
    double start_change = 0;
    for (int k = 0; k < 3; ++k)
        start_change = std::max(start_change, std::fabs(start[k] - last_start_[k]));
    last_start_ = start;
    const double state =
        weights.state * (weights.change * start_change + map_error * orbit.condition());
    const double watts = state * orbit.sensitivity(CycleState::kDissipated, scale) / map_.time();
    double mismatch = 0;  // difference of the joints' work and the dissipation, W
    if (options_.powers) {
        mismatch = std::fabs(orbit.end.work.net - orbit.end.state.dissipated) / map_.time();
        add_positive(orbit.end.work, mismatch + watts, next);
    }
    const Change change{
        std::fabs(next.speed - coarse_.speed), std::fabs(next.power - coarse_.power),
        std::fabs(next.turn - coarse_.turn),
        // Both may be the logarithm of zero.
        next.log_largest_multiplier == coarse_.log_largest_multiplier
            ? 0
            : std::fabs(next.log_largest_multiplier - coarse_.log_largest_multiplier)};
    const auto error = [&](double Change::* field, double remainder, double value) {
        const double sum =
            weights.change * change.*field + weights.last_change * last_change_.*field + remainder;
        return stated_error(sum, options_.rtol, value);
    };
    next.speed_error = error(&Change::speed, state * scale[0] / map_.nm(), next.speed);
    next.power_error = error(&Change::power,
                             weights.power * map_error * next.power + watts + mismatch, next.power);
    const double radians =
        weights.power * map_error + state * orbit.sensitivity(CycleState::kTheta, scale);
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

// Solve for the state at a tolerance. The goal for Newton's last step is a multiple of the
// tolerance or of its root, but on smooth ground, where the map is more accurate, only of the
// tolerance.
FixedPoint::Ended Refinement::level(double tolerance, SteadyState& next) {
    const double root = map_.smooth() ? 0 : kLevels.root_factor * std::sqrt(tolerance);
    const double max_step = std::max(kLevels.goal_factor * tolerance, root);
    const double goal =
        options_.rough
            ? kLevels.rough_goal
            : std::max((point_.start_solved ? 1 : kLevels.first_goal) * max_step, kLevels.min_goal);
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

// If a level fails at one tolerance, another one mostly succeeds; so there are several tries.
SteadyState Refinement::refine(double first_tolerance, const Acceptance& accepted) {
    SteadyState best = SteadyState::unknown();
    last_start_ = point_.start;
    point_.start_solved = false;
    double tolerance =
        map_.smooth() ? std::min(first_tolerance, kLevels.first_smooth) : first_tolerance;
    for (int failures = 0; tolerance > kLevels.min_tolerance;) {
        SteadyState next;
        const auto ended = level(tolerance, next);
        if (ended != FixedPoint::Ended::converged) {
            if (++failures == kLevels.tries) break;
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
        tolerance *= kLevels.reduction;
    }
    return best;
}

}  // namespace serpenoid
