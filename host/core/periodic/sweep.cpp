// The threads of sweep.hpp.
#include "periodic/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "periodic/dry.hpp"
#include "periodic/spectral.hpp"
#include "periodic/viscous.hpp"

namespace serpenoid {

namespace {

void put(const SteadyState& s, double* to) {
    to[kSpeed] = s.speed, to[kPower] = s.power;
    to[kAbsPower] = s.abs_power, to[kPositivePower] = s.positive_power, to[kTurn] = s.turn;
    to[kSpeedError] = s.speed_error, to[kPowerError] = s.power_error;
    to[kPositivePowerError] = s.positive_power_error;
    to[kSlowest] = s.slowest, to[kSlowestError] = s.slowest_error;
    to[kConverged] = s.converged ? 1 : 0;
}

template <class Solver>
void solve_rates(Solver&& solver, const std::vector<double>& omegas, const SteadyOptions& options,
                 double* to) {
    for (const double omega : omegas) put(solver.solve(omega, options), to), to += kSweepColumns;
}

// Rates in packs; those that no pack resolves one by one, by elements.
void solve_viscous(const SweepShape& k, const std::vector<double>& omegas,
                   const SteadyOptions& options, double* to) {
    SteadyViscous by_elements(k.robot, k.ground, k.gait);
    if (k.gait.offset != 0) return solve_rates(by_elements, omegas, options, to);
    SpectralViscous packs(k.robot, k.ground, k.gait);
    std::vector<SteadyState> found(packs.width());
    for (std::size_t first = 0; first < omegas.size(); first += found.size()) {
        const std::size_t count = std::min(found.size(), omegas.size() - first);
        packs.solve(&omegas[first], static_cast<int>(count), options, found.data());
        for (std::size_t i = 0; i < count; ++i, to += kSweepColumns)
            put(found[i].converged ? found[i] : by_elements.solve(omegas[first + i], options), to);
    }
}

}  // namespace

SteadyState steady_state(const SweepShape& k, const SteadyOptions& options) {
    const double omega = k.gait.omega;
    if (!k.ground.smooth()) return SteadyDry(k.robot, k.ground, k.gait).solve(omega, options);
    if (k.gait.offset == 0) {
        SteadyState found;
        SpectralViscous(k.robot, k.ground, k.gait).solve(&omega, 1, options, &found);
        if (found.converged) return found;
    }
    return SteadyViscous(k.robot, k.ground, k.gait).solve(omega, options);
}

namespace {

void solve_shape(const SweepShape& k, const std::vector<double>& omegas,
                 const SteadyOptions& options, double* to) {
    if (!k.ground.smooth())
        solve_rates(SteadyDry(k.robot, k.ground, k.gait), omegas, options, to);
    else
        solve_viscous(k, omegas, options, to);
}

}  // namespace

void sweep_shapes(const std::vector<SweepShape>& shapes, const std::vector<double>& omegas,
                  const SteadyOptions& options, int threads, const std::function<bool(long)>& go_on,
                  double* to) {
    using namespace std::chrono_literals;
    std::atomic<std::size_t> next = 0;
    std::atomic<long> done = 0;
    std::atomic<bool> stop = false;
    std::mutex lock;
    std::condition_variable ended;
    int running = threads;
    const auto work = [&] {
        for (std::size_t k; !stop && (k = next++) < shapes.size();) {
            solve_shape(shapes[k], omegas, options, to + k * omegas.size() * kSweepColumns);
            done += static_cast<long>(omegas.size());
        }
        const std::lock_guard<std::mutex> hold(lock);
        --running;
        ended.notify_one();
    };
    std::vector<std::thread> pool;
    for (int i = 0; i < threads; ++i) pool.emplace_back(work);
    {
        std::unique_lock<std::mutex> hold(lock);
        while (!ended.wait_for(hold, 100ms, [&] { return running == 0; })) {
            hold.unlock();
            if (!stop && !go_on(done.exchange(0))) stop = true;
            hold.lock();
        }
    }
    for (std::thread& t : pool) t.join();
    if (!stop) go_on(done.exchange(0));
}

}  // namespace serpenoid
