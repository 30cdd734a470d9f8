// Starts and continuation of steady.hpp.
#include "periodic/steady.hpp"

#include <algorithm>
#include <cmath>

#include "periodic/pieces/sliding_cycle.hpp"
#include "periodic/refinement.hpp"

namespace serpenoid {

namespace {

// Wheels at rest may leave so little of a disturbance that only rounding is left: then a multiplier
// is known to be small, but not how small.
SteadyState within_rounding(SteadyState s) {
    constexpr double kLeast = -30;  // of its logarithm
    if (s.log_largest_multiplier < kLeast) {
        s.log_largest_multiplier = kLeast;
        s.log_multiplier_error = -kLeast;
    }
    return s;
}

constexpr double kSettled = 0.02;  // a cycle's change, over the scales

constexpr double kWidest = 1e-4;  // rtol below which a lost state is searched with ten times it

// The first tolerance: the second level is then mostly enough.
double first_tolerance(double rtol) {
    constexpr double kPart = 0.12;      // of what is asked
    constexpr double kTightest = 1e-7;  // a loose level before it costs little
    constexpr double kLoosest = 3e-4;   // Newton's method seldom converges beyond it
    return std::clamp(kPart * rtol, kTightest, kLoosest);
}

}  // namespace

// Joints at rest give no scales. Disturbances decay as in the smallest waves; speed and power are
// zero.
SteadyState SteadyByPieces::at_rest(double omega, const SteadyOptions& options) const {
    constexpr double kSmallWave = 1e-3;  // rad
    Gait small = gait_;
    small.alpha = kSmallWave;
    const SteadyState waving = SteadyByPieces(robot_, ground_, small).solve(omega, options);
    SteadyState state;
    state.monodromy = waving.monodromy;
    state.log_largest_multiplier = waving.log_largest_multiplier;
    state.log_multiplier_error = waving.log_multiplier_error;
    state.converged = true;
    return state;
}

// Newton's method mostly needs no settled start. A search that breaks off with one sequence of
// tolerances mostly succeeds with another. An unstable state is accepted only if a motion led to
// it. From rest, half of the first cycle's change is applied: the angular momentum of a fast gait
// hardly changes, but the mirror changes its sign.
void SteadyByPieces::search_from_rest(CycleMap& map, FixedPoint& point, const Acceptance& accepted,
                                      const SteadyOptions& options, SteadyState& best) const {
    struct Try {
        double tolerance;  // of the first one
        int cycles;
    };
    constexpr Try kTries[] = {{1, 4}, {0.03, 4}, {1, 200}, {0.3, 4}, {0.1, 4}, {30, 4}, {100, 4}};
    constexpr int kFewCycles = 4;
    constexpr double kFollowing = 1e-3;  // tolerance of the cycles before the search
    bool settled = false;
    for (const auto& [tolerance, cycles] : kTries) {
        const double share = settled ? 1 : 0.5;
        if (!settled) point.start = {0, 0, map.momentum_at_rest() / map.scale()[2]};
        settled = settled || cycles > kFewCycles;
        if (!point.follow_cycles(cycles, kSettled, kFollowing * tolerance, share)) continue;
        SteadyState state = Refinement(map, point, options)
                                .refine(tolerance * first_tolerance(options.rtol), accepted);
        if (!settled && state.log_largest_multiplier > 0) state.converged = false;
        if (state.converged || accepted.excess(state) < accepted.excess(best)) best = state;
        if (best.converged) break;
    }
}

SteadyState SteadyByPieces::solve(double omega, const SteadyOptions& options, const Vec3* start) {
    constexpr int kMaxPieces = 600'000;  // of a whole search, over the links: some seconds
    if (gait_.alpha == 0) return at_rest(omega, options);
    gait_.omega = omega;
    const Acceptance accepted(options, robot_, ground_, omega);
    SlidingCycle map(robot_, ground_, gait_, kMaxPieces / robot_.n);
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
    if (!best.converged && options.rtol < kWidest) {  // where wheels chatter tight pieces break off
        SteadyOptions wider = options;
        wider.rtol *= 10;
        const SteadyState rough = solve(omega, wider);
        if (accepted.excess(rough) < accepted.excess(best)) best = rough;
        best.converged = best.converged && accepted(best);
    }
    return within_rounding(best);
}

}  // namespace serpenoid
