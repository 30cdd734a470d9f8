// Periodic states of many shapes and rates by threads, for sweep.hpp.
#include "periodic/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>

#include "periodic/steady.hpp"
#include "periodic/viscous/spectral.hpp"

namespace serpenoid {

namespace {

// Periodic states of one shape at these rates. On viscous ground packs of rates are solved by the
// spectral method. Dry ground, steering gaits, and states that it does not resolve, use pieces.
std::vector<SteadyState> states_of(const SweepShape& shape, const std::vector<double>& omegas,
                                   const SteadyOptions& options) {
    const auto& [robot, ground, gait] = shape;
    const int count = static_cast<int>(omegas.size());
    std::vector<SteadyState> states(count);
    if (ground.smooth() && gait.offset == 0) {
        SpectralViscous packs(robot, ground, gait);
        for (int k = 0; k < count; k += kPack)
            packs.solve(&omegas[k], std::min(kPack, count - k), options, &states[k]);
    }
    SteadyByPieces pieces(robot, ground, gait);
    for (int k = 0; k < count; ++k)
        if (!states[k].converged) states[k] = pieces.solve(omegas[k], options);
    return states;
}

// Run `count` tasks by several threads; a task returns the number of gaits that it solved.
void run_parallel(std::size_t count, int threads, const KeepRunning& keep_running,
                  const std::function<long(std::size_t)>& task) {
    std::atomic<std::size_t> next = 0;
    std::atomic<long> gaits = 0;
    std::atomic<bool> stop = false;
    const auto work = [&] {
        for (std::size_t k = next++; !stop && k < count; k = next++) gaits += task(k);
    };
    std::vector<std::future<void>> pool(std::max(threads, 1));
    for (auto& worker : pool) worker = std::async(std::launch::async, work);
    for (auto& worker : pool) {
        while (worker.wait_for(std::chrono::milliseconds(100)) != std::future_status::ready)
            stop = stop || !keep_running(gaits.exchange(0));
        worker.get();
    }
    if (!stop) keep_running(gaits);
}

}  // namespace

SteadyState steady_state(const SweepShape& shape, const SteadyOptions& options) {
    return states_of(shape, {shape.gait.omega}, options).front();
}

void sweep_shapes(const std::vector<SweepShape>& shapes, const std::vector<double>& omegas,
                  const SteadyOptions& options, int threads, const KeepRunning& keep_running,
                  double* columns) {
    run_parallel(shapes.size(), threads, keep_running, [&](std::size_t k) {
        double* column = columns + k * omegas.size() * kSweepColumns;
        for (const SteadyState& state : states_of(shapes[k], omegas, options)) {
            for (double SteadyState::* field : kSweepFields) *column++ = state.*field;
            *column++ = state.converged ? 1 : 0;
        }
        return static_cast<long>(omegas.size());
    });
}

std::vector<SteadyState> neighbours(const SweepShape& middle, const std::vector<SweepShape>& shapes,
                                    const SteadyOptions& options, int threads,
                                    const KeepRunning& keep_running,
                                    const std::vector<Vec3>& starts) {
    SteadyByPieces begin(middle.robot, middle.ground, middle.gait);
    if (!middle.ground.smooth() && starts.empty())
        begin.solve(middle.gait.omega, {options.rtol, false});
    std::vector<SteadyState> states(shapes.size());
    run_parallel(shapes.size(), threads, keep_running, [&](std::size_t k) {
        const auto& [robot, ground, gait] = shapes[k];
        SteadyByPieces dry(robot, ground, gait, begin);
        const Vec3* start = starts.empty() ? nullptr : &starts[k];
        states[k] = ground.smooth() ? steady_state(shapes[k], options)
                                    : dry.solve(gait.omega, options, start);
        return 1L;
    });
    return states;
}

}  // namespace serpenoid
