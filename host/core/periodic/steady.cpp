// The search of steady.hpp: its starts, and its repetition with other tolerances.
#include "periodic/steady.hpp"

#include <algorithm>
#include <cmath>

#include "periodic/pieces/sliding_cycle.hpp"
#include "periodic/refinement.hpp"

namespace serpenoid {

namespace {

// Tolerances and limits of the search; tests/host/periodic/test_dry_failures.py counts how many
// random gaits have no state.
struct SearchTuning {
    double min_log = -30;          // least logarithm of a multiplier above rounding errors
    double settled = 0.02;         // change in a cycle, in units of the scales, of a settled motion
    double max_retry_rtol = 1e-4;  // rtol below which a failed search is repeated with 10 rtol
    double rtol_share = 0.12;  // first tolerance over rtol: the second level is mostly sufficient
    double tightest = 1e-7;    // first tolerance: a looser level before a tighter one costs little
    double loosest = 3e-4;     // tolerance at which Newton's method mostly converges
    double cycle_tolerance = 1e-3;  // tolerance of the cycles before the search
    int max_pieces = 600'000;       // pieces times links in a search, which then takes seconds
};
constexpr SearchTuning kSearch;

// Sticking wheels may damp a disturbance to the size of rounding errors. The largest multiplier is
// then known to be small, but not its value.
SteadyState limit_multiplier(SteadyState state) {
    if (state.log_largest_multiplier < kSearch.min_log) {
        state.log_largest_multiplier = kSearch.min_log;
        state.log_multiplier_error = -kSearch.min_log;
    }
    return state;
}

double first_tolerance(double rtol) {
    return std::clamp(kSearch.rtol_share * rtol, kSearch.tightest, kSearch.loosest);
}

}  // namespace

// The state of a gait without amplitude, whose motion gives no scales: speed and power are zero,
// and disturbances decay as with a very small amplitude.
SteadyState SteadyByPieces::at_rest(double omega, const SteadyOptions& options) const {
    Gait small = gait_;
    small.alpha = 1e-3;
    const SteadyState moving = SteadyByPieces(robot_, ground_, small).solve(omega, options);
    SteadyState state;
    state.monodromy = moving.monodromy;
    state.log_largest_multiplier = moving.log_largest_multiplier;
    state.log_multiplier_error = moving.log_multiplier_error;
    state.converged = true;
    return state;
}

// Newton's method mostly converges from a start that has not settled. If a search fails with one
// sequence of tolerances, another one mostly succeeds. An unstable state is accepted only if the
// motion of many cycles led to it. From rest, half of the change in the first cycle is applied: the
// angular momentum of a fast gait hardly changes, but the mirror image changes its sign.
void SteadyByPieces::search_from_rest(CycleMap& map, FixedPoint& point, const Acceptance& accepted,
                                      const SteadyOptions& options, SteadyState& best) const {
    struct Try {
        double tolerance;  // factor on the first tolerance
        int cycles;
    };
    constexpr Try kTries[] = {{1, 4}, {0.03, 4}, {1, 200}, {0.3, 4}, {0.1, 4}, {30, 4}, {100, 4}};
    bool settled = false;
    for (const auto& [tolerance, cycles] : kTries) {
        const double share = settled ? 1 : 0.5;
        if (!settled) point.start = {0, 0, map.momentum_at_rest() / map.scale()[2]};
        settled = settled || cycles > kTries[0].cycles;
        if (!point.follow_cycles(cycles, kSearch.settled, kSearch.cycle_tolerance * tolerance,
                                 share))
            continue;
        SteadyState state = Refinement(map, point, options)
                                .refine(tolerance * first_tolerance(options.rtol), accepted);
        if (!settled && state.log_largest_multiplier > 0) state.converged = false;
        if (state.converged || accepted.excess(state) < accepted.excess(best)) best = state;
        if (best.converged) break;
    }
}

SteadyState SteadyByPieces::solve(double omega, const SteadyOptions& options, const Vec3* start) {
    if (gait_.alpha == 0) return at_rest(omega, options);
    gait_.omega = omega;
    const Acceptance accepted(options, robot_, ground_, omega);
    SlidingCycle map(robot_, ground_, gait_, kSearch.max_pieces / robot_.n);
    FixedPoint point(map, promising_ && last_);
    SteadyState best = SteadyState::unknown();
    if (start || last_) {
        point.start = start ? map.scaled(*start) : *last_;
        best = Refinement(map, point, options).refine(first_tolerance(options.rtol), accepted);
    }
    if (!best.converged) search_from_rest(map, point, accepted, options, best);
    promising_ = point.promising();
    last_.reset();
    if (best.converged) last_ = point.start;
    // Tight tolerances fail where wheels chatter.
    if (!best.converged && options.rtol < kSearch.max_retry_rtol) {
        SteadyOptions wider = options;
        wider.rtol *= 10;
        const SteadyState rough = solve(omega, wider);
        if (accepted.excess(rough) < accepted.excess(best)) best = rough;
        best.converged = best.converged && accepted(best);
    }
    return limit_multiplier(best);
}

}  // namespace serpenoid
