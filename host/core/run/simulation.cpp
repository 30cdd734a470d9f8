// Runs in time: composes system and method once, then steps and records.
#include "run/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>

#include "methods/adaptive/dop853.hpp"
#include "methods/adaptive/mode_steps.hpp"
#include "methods/adaptive/radau.hpp"
#include "methods/paper_scheme.hpp"
#include "methods/rk4.hpp"
#include "methods/stick_slip.hpp"
#include "run/positive_work.hpp"
#include "run/recorder.hpp"
#include "scene/system.hpp"

namespace serpenoid {
namespace {

// SI units: no robot goes so far or so fast. Forces and powers, squares and cubes of states, are
// finite below it.
constexpr double kLargestState = 1e30;

bool bounded(const double* y, int dim) {
    return std::all_of(y, y + dim, [](double value) { return std::abs(value) < kLargestState; });
}

// Steps from one jump to the next and notes the times of the grid.
class Run {
  public:
    // `positive`: null where none is to be found.
    Run(const RunRequest& request, System& system, Method& method, Recorder& recorder,
        PositiveWork* positive)
        : request_(request),
          system_(system),
          method_(method),
          recorder_(recorder),
          positive_(positive),
          y_(system.dim()),
          dense_(method.dense_order() > 0),
          steps_unchecked_(std::clamp(512L / request.robot.n, 1L, 64L)),
          unchecked_(steps_unchecked_),
          due_(recorded(1)) {}

    RunResult run() {
        system_.write_state(start_chain(request_), y_.data());
        system_.fill_chain(0, y_.data());
        system_.latch();
        begin(0);
        recorder_.note(0, y_.data(), result_);
        double t = 0;
        while (t < request_.duration && result_.why.empty() && result_.failed_at < 0) {
            const double stop = std::min(system_.next_jump(t), request_.duration);
            if (t > 0) begin(t);
            smooth_part(stop);
            t = stop;
        }
        return std::move(result_);
    }

  private:
    void begin(double t) {
        system_.handle_jump(t, y_.data());
        method_.restart(t, y_.data());
    }
    void smooth_part(double stop) {
        for (bool more = true; more;) {
            // without dense output the steps must end on what is recorded
            const double limit = dense_ ? stop : std::min(stop, due_);
            const StepOutcome step = method_.step(limit);
            const double t = method_.time();
            more = t < stop;
            if (!step.ok) return give_up(t, step.why);
            if (const double e = method_.local_error(); e == e) result_.error += e;
            ++result_.steps;
            if (positive_) positive_->step();
            if (--unchecked_ == 0 && !checked(t)) return;
            if (due_ <= t && !note_until(t)) return;
        }
        std::copy_n(method_.state(), y_.size(), y_.begin());
    }

    // The k-th recorded time: the end comes last.
    double recorded(long k) const {
        const long long step = k * request_.record_steps;
        return step >= request_.steps ? request_.duration : static_cast<double>(step) * request_.dt;
    }
    bool note_until(double t) {
        if (!checked(t)) return false;
        for (; !done_ && due_ <= t; due_ = recorded(++next_)) {
            const double row_time = due_;
            if (row_time == t)
                std::copy_n(method_.state(), y_.size(), y_.begin());
            else
                method_.dense(row_time, y_.data());
            recorder_.note(row_time, y_.data(), result_);
            done_ = row_time >= request_.duration;
        }
        return true;
    }
    bool checked(double t) {
        unchecked_ = steps_unchecked_;
        if (!bounded(method_.state(), system_.dim())) {
            result_.failed_at = t;
            return false;
        }
        if (!ask(t)) return give_up(t, "it was interrupted"), false;
        if (result_.steps > request_.max_steps) return give_up(t, "it took too many steps"), false;
        return true;
    }
    // Ask whether to go on, 50 times a second at most: the answer may be an exception.
    bool ask(double t) {
        if (!request_.keep_running) return true;
        const auto clock_time = std::chrono::steady_clock::now();
        if (clock_time < question_time_ + std::chrono::milliseconds(20)) return true;
        question_time_ = clock_time;
        return request_.keep_running(t);
    }
    void give_up(double t, const char* why) {
        result_.failed_at = t;
        result_.why = why;
    }

    const RunRequest& request_;
    System& system_;
    Method& method_;
    Recorder& recorder_;
    PositiveWork* positive_;
    std::vector<double> y_;
    RunResult result_;
    std::chrono::steady_clock::time_point question_time_ = std::chrono::steady_clock::now();
    bool dense_, done_ = false;
    long steps_unchecked_, unchecked_, next_ = 1;
    double due_;
};

// The method of a request's name, which steps a system.
std::unique_ptr<Method> make_method(const RunRequest& request, System& system) {
    const auto is = [&request](const char* name) { return request.method.is(name); };
    if (is("rk4")) return std::make_unique<Rk4>(system, request.dt);
    if (is("paper")) return std::make_unique<PaperScheme>(system, request.dt);
    const std::vector<double> scale = error_scale(system, request);
    if (is("dop853")) return std::make_unique<Dop853>(system, scale, request.tolerance);
    if (is("radau")) return std::make_unique<Radau>(system, scale, request.tolerance);
    if (request.formulation == Formulation::implicit)
        return std::make_unique<StickSlip>(system, request.robot, request.ground, request.dt);
    return std::make_unique<ModeSteps>(system, *system.sticking(), scale, mode_tolerance(request),
                                       1e-12 / rate_unit(request));
}

}  // namespace

RunResult simulate(const RunRequest& request) {
    System system(request);
    const std::unique_ptr<Method> method = make_method(request, system);
    std::optional<PositiveWork> positive;
    if (request.record_energy && method->dense_order() > 0) positive.emplace(system, *method);
    PositiveWork* const work = positive ? &*positive : nullptr;
    Recorder recorder(request, system, *method, work);
    return Run(request, system, *method, recorder, work).run();
}

}  // namespace serpenoid
