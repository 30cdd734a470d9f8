// The threads of sweep.hpp.
#include "periodic/sweep.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <thread>
#include <utility>

#include "periodic/rates_of_shape.hpp"

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

// Rates in this order, so that packs start from rates beside theirs.
void solve_viscous(const SweepShape& k, const std::vector<double>& omegas,
                   const std::vector<std::size_t>& order, const SteadyOptions& options,
                   double* to) {
    std::vector<double> rates;
    for (const std::size_t i : order) rates.push_back(omegas[i]);
    std::vector<SteadyState> found(rates.size());
    RatesOfShape(k.robot, k.ground, k.gait)
        .solve(rates.data(), static_cast<int>(rates.size()), options, found.data());
    for (std::size_t j = 0; j < order.size(); ++j) put(found[j], to + order[j] * kSweepColumns);
}

// The rates whose states the others are begun from come first: each the one that is farthest, as a
// ratio, from all before it.
std::vector<std::size_t> spread(const std::vector<double>& omegas) {
    constexpr std::size_t kFirst = 16;
    std::vector<std::size_t> order(omegas.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return omegas[a] < omegas[b]; });
    std::vector<double> gap(omegas.size(), HUGE_VAL);
    for (std::size_t k = 0; k + 1 < std::min(kFirst, order.size()); ++k) {
        std::size_t farthest = k + 1;
        for (std::size_t i = k + 1; i < order.size(); ++i) {
            double& g = gap[order[i]];
            g = std::min(g, std::fabs(std::log(omegas[order[i]] / omegas[order[k]])));
            if (g > gap[order[farthest]]) farthest = i;
        }
        std::rotate(order.begin() + k + 1, order.begin() + farthest, order.begin() + farthest + 1);
    }
    return order;
}

// Do `count` tasks in this thread; a task returns the number of gaits it solved.
void in_turn(std::size_t count, const std::function<bool(long)>& go_on,
             const std::function<long(std::size_t)>& task) {
    using Clock = std::chrono::steady_clock;
    long done = 0;
    auto told = Clock::now();
    for (std::size_t k = 0; k < count; ++k) {
        done += task(k);
        if (Clock::now() - told < std::chrono::milliseconds(100)) continue;
        if (!go_on(std::exchange(done, 0))) return;
        told = Clock::now();
    }
    go_on(done);
}

// Share `count` tasks out to threads; a task returns the number of gaits it solved.
void share_out(std::size_t count, int threads, const std::function<bool(long)>& go_on,
               const std::function<long(std::size_t)>& task) {
    if (threads <= 1) return in_turn(count, go_on, task);
    using namespace std::chrono_literals;
    std::atomic<std::size_t> next = 0;
    std::atomic<long> done = 0;
    std::atomic<bool> stop = false;
    std::mutex lock;
    std::condition_variable ended;
    int running = threads;
    const auto work = [&] {
        for (std::size_t k; !stop && (k = next++) < count;) done += task(k);
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

}  // namespace

SteadyState steady_state(const SweepShape& k, const SteadyOptions& options) {
    const double omega = k.gait.omega;
    if (!k.ground.smooth()) return SteadyByPieces(k.robot, k.ground, k.gait).solve(omega, options);
    SteadyState found;
    RatesOfShape(k.robot, k.ground, k.gait).solve(&omega, 1, options, &found);
    return found;
}

void sweep_shapes(const std::vector<SweepShape>& shapes, const std::vector<double>& omegas,
                  const SteadyOptions& options, int threads, const std::function<bool(long)>& go_on,
                  double* to) {
    const std::vector<std::size_t> order = spread(omegas);
    share_out(shapes.size(), threads, go_on, [&](std::size_t k) {
        double* own = to + k * omegas.size() * kSweepColumns;
        const auto& [robot, ground, gait] = shapes[k];
        if (ground.smooth())
            solve_viscous(shapes[k], omegas, order, options, own);
        else
            solve_rates(SteadyByPieces(robot, ground, gait), omegas, options, own);
        return static_cast<long>(omegas.size());
    });
}

std::vector<SteadyState> neighbours(const SweepShape& middle, const std::vector<SweepShape>& shapes,
                                    const SteadyOptions& options, int threads,
                                    const std::function<bool(long)>& go_on,
                                    const std::vector<Vec3>& starts) {
    SteadyByPieces begin(middle.robot, middle.ground, middle.gait);
    if (!middle.ground.smooth() && starts.empty())
        begin.solve(middle.gait.omega, {options.rtol, false, 0});
    std::vector<SteadyState> found(shapes.size());
    share_out(shapes.size(), threads, go_on, [&](std::size_t k) {
        const auto& [robot, ground, gait] = shapes[k];
        if (ground.smooth()) {
            found[k] = steady_state(shapes[k], options);
            return 1L;
        }
        SteadyByPieces dry(robot, ground, gait, begin);
        if (!starts.empty()) dry.start_from(starts[k]);
        found[k] = dry.solve(gait.omega, options);
        return 1L;
    });
    return found;
}

}  // namespace serpenoid
