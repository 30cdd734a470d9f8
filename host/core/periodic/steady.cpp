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
    if (s.slowest < kLeast) s.slowest = kLeast, s.slowest_error = -kLeast;
    return s;
}

constexpr double kSettled = 0.02;  // a cycle's change, over the scales

constexpr double kWidest = 1e-4;  // rtol up to which a state that is lost is looked for again

// The first tolerance: the second level is then mostly enough.
double first_tolerance(double rtol) { return std::clamp(0.12 * rtol, 1e-7, 3e-4); }

// Newton's last step is short where pieces are that accurate: what it misses is its square.
Levels levels(const CycleMap& map, double first) {
    Levels to{first};
    if (map.smooth()) to.first = std::min(first, 1e-6), to.root_goal = 0;
    return to;
}

}  // namespace

// The parabola through the last three rates' states, over the period, or the line through two,
// unless that is far out.
Vec3 SteadyByPieces::guess(double omega) const {
    constexpr double kFar = 8;
    for (std::size_t count = solutions_.size(); count > 1; --count) {
        const Solution* const from = solutions_.data() + solutions_.size() - count;
        Vec3 z{};
        double weights = 0;
        for (std::size_t k = 0; k < count; ++k) {
            double weight = 1;
            for (std::size_t j = 0; j < count; ++j)
                if (j != k)
                    weight *=
                        (1 / omega - 1 / from[j].omega) / (1 / from[k].omega - 1 / from[j].omega);
            weights += std::fabs(weight);
            for (int i = 0; i < 3; ++i) z[i] += weight * from[k].z[i];
        }
        if (weights <= kFar) return z;
    }
    return solutions_.back().z;
}

// Keep a state for the rates to come; after one that failed they begin anew.
void SteadyByPieces::remember(double omega, const Vec3& z, bool converged) {
    if (!converged) solutions_.clear();
    std::erase_if(solutions_, [&](const Solution& k) { return k.omega == omega; });
    if (solutions_.size() == 3) solutions_.erase(solutions_.begin());
    if (converged) solutions_.push_back({omega, z});
}

// Joints at rest give no scales. Disturbances decay as in the smallest waves; speed and power are
// zero.
SteadyState SteadyByPieces::at_rest(double omega, const SteadyOptions& options) const {
    Gait small = gait_;
    small.alpha = 1e-3;
    const SteadyState waving = SteadyByPieces(robot_, ground_, small).solve(omega, options);
    SteadyState rest;
    rest.monodromy = waving.monodromy, rest.slowest = waving.slowest;
    rest.slowest_error = waving.slowest_error;
    rest.iterations = waving.iterations, rest.converged = true;
    return rest;
}

// Newton's method mostly needs no settled start. A search that breaks off with one sequence of
// tolerances mostly succeeds with another. An unstable state is accepted only if a motion led to
// it. From rest, half of the first cycle's change is applied: the angular momentum of a fast gait
// hardly changes, but the mirror changes its sign.
void SteadyByPieces::from_rest(CycleMap& map, FixedPoint& point, const Acceptance& accepted,
                               const SteadyOptions& options, SteadyState& out) const {
    struct Try {
        double from;
        int cycles;
    };
    constexpr Try kTries[] = {{1, 4}, {0.03, 4}, {1, 200}, {0.3, 4}, {0.1, 4}, {30, 4}, {100, 4}};
    bool settled = false;
    for (const auto& [from, cycles] : kTries) {
        const double share = settled ? 1 : 0.5;
        if (!settled) point.z = {0, 0, map.momentum_at_rest() / map.scale()[2]};
        settled = settled || cycles > 4;
        if (!point.follow_cycles(cycles, kSettled, 1e-3 * from, share)) continue;
        SteadyState anew = Refinement(map, point, options)
                               .refine(levels(map, from * first_tolerance(options.rtol)), accepted);
        if (!settled && anew.slowest > 0) anew.converged = false;
        if (anew.converged || accepted.excess(anew) < accepted.excess(out)) out = anew;
        if (out.converged) break;
    }
}

SteadyState SteadyByPieces::solve(double omega, const SteadyOptions& options) {
    if (gait_.alpha == 0) return at_rest(omega, options);
    gait_.omega = omega;
    const Acceptance accepted(options, robot_, ground_, omega);
    SlidingCycle map(robot_, ground_, gait_, 600'000 / robot_.n);
    FixedPoint point(map, promising_ && solutions_.size() > 1);
    SteadyState out = SteadyState::unknown();
    if (start_ || !solutions_.empty()) {
        point.z = start_ ? map.scaled(*start_) : guess(omega);
        start_.reset();
        out = Refinement(map, point, options)
                  .refine(levels(map, first_tolerance(options.rtol)), accepted);
    }
    if (!out.converged) from_rest(map, point, accepted, options, out);
    promising_ = point.promising();
    remember(omega, point.z, out.converged);
    if (!out.converged && options.rtol < kWidest) {  // where wheels chatter tight pieces break off
        SteadyOptions wider = options;
        wider.rtol *= 10;
        const SteadyState rough = solve(omega, wider);
        if (accepted.excess(rough) < accepted.excess(out)) out = rough;
        out.converged = out.converged && accepted(out);
    }
    return within_rounding(out);
}

}  // namespace serpenoid
