// The threads of sweep.hpp.
#include "periodic/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
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
    SteadyState state;
    RatesOfShape(k.robot, k.ground, k.gait).solve(&k.gait.omega, 1, options, &state);
    return state;
}

void sweep_shapes(const std::vector<SweepShape>& shapes, const std::vector<double>& omegas,
                  const SteadyOptions& options, int threads, const std::function<bool(long)>& go_on,
                  double* to) {
    share_out(shapes.size(), threads, go_on, [&](std::size_t k) {
        const auto& [robot, ground, gait] = shapes[k];
        const int rates = static_cast<int>(omegas.size());
        std::vector<SteadyState> states(rates);
        RatesOfShape(robot, ground, gait).solve(omegas.data(), rates, options, states.data());
        for (int i = 0; i < rates; ++i) put(states[i], to + (k * rates + i) * kSweepColumns);
        return long{rates};
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
