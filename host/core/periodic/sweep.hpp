// Periodic states of many shapes at many rates: shapes are shared out to threads, and what a shape
// needs once (viscous ground: its tables; dry ground: a state to start from) serves all its rates.
#pragma once

#include <functional>
#include <iterator>
#include <vector>

#include "model/params.hpp"
#include "periodic/periodic_state.hpp"

namespace serpenoid {

// A robot on its ground, and the shape of its gait; the gait's omega does not count
// in sweeps.
struct SweepShape {
    Robot robot;
    Ground ground;
    Gait gait;
};

// The periodic state of one, at the gait's own rate.
SteadyState steady_state(const SweepShape& shape, const SteadyOptions& options);

// The columns of a sweep; one more is 1 where the state has converged, else 0.
constexpr double SteadyState::* kSweepFields[] = {
    &SteadyState::speed,
    &SteadyState::power,
    &SteadyState::abs_power,
    &SteadyState::positive_power,
    &SteadyState::turn,
    &SteadyState::speed_error,
    &SteadyState::power_error,
    &SteadyState::positive_power_error,
    &SteadyState::log_largest_multiplier,
    &SteadyState::log_multiplier_error,
};
constexpr std::size_t kSweepColumns = std::size(kSweepFields) + 1;

// Called now and then, in the caller's thread, with the number of gaits done since its last call;
// false ends the work after the shapes in hand.
using KeepRunning = std::function<bool(long)>;

// Fills columns[(shape * rates + rate) * kSweepColumns + column]. A shape is solved rate by rate in
// one thread, from nothing, so neither the threads nor the other shapes change a bit of it.
void sweep_shapes(const std::vector<SweepShape>& shapes, const std::vector<double>& omegas,
                  const SteadyOptions& options, int threads, const KeepRunning& keep_running,
                  double* columns);

// The periodic states of shapes that are all alike, each at its own gait's rate. On dry ground they
// begin at the state of `middle`, or each at its own velocities in the body frame at phase 0 where
// `starts` has any.
std::vector<SteadyState> neighbours(const SweepShape& middle, const std::vector<SweepShape>& shapes,
                                    const SteadyOptions& options, int threads,
                                    const KeepRunning& keep_running,
                                    const std::vector<Vec3>& starts = {});

}  // namespace serpenoid
