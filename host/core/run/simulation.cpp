// Runs in time: composes system and method once, then steps and records.
#include "run/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>

#include "methods/adaptive/dop853.hpp"
#include "methods/adaptive/mode_steps.hpp"
#include "methods/adaptive/switched_steps.hpp"
#include "methods/paper_scheme.hpp"
#include "methods/rk4.hpp"
#include "methods/stick_slip.hpp"
#include "run/positive_work.hpp"
#include "scene/system.hpp"

namespace serpenoid {
namespace {

// SI units: no robot goes so far or so fast. Forces and powers, squares and cubes of states, are
// finite below it.
constexpr double kLargestState = 1e30;

bool bounded(const double* y, int dim) {
    return std::all_of(y, y + dim, [](double value) { return std::abs(value) < kLargestState; });
}

// The method of a request's name, which steps a system.
std::unique_ptr<Method> make_method(const RunRequest& request, System& system) {
    const auto is = [&request](const char* name) { return request.method.is(name); };
    if (is("rk4")) return std::make_unique<Rk4>(system, request.dt);
    if (is("paper")) return std::make_unique<PaperScheme>(system, request.dt);
    const std::vector<double> scale = error_scale(system, request);
    if (is("dop853")) return std::make_unique<Dop853>(system, scale, request.tolerance);
    if (is("radau")) return std::make_unique<SwitchedSteps>(system, scale, request.tolerance);
    if (request.formulation == Formulation::implicit)
        return std::make_unique<StickSlip>(system, request.robot, request.ground, request.dt);
    return std::make_unique<ModeSteps>(system, *system.sticking(), scale, mode_tolerance(request),
                                       1e-12 / rate_unit(request));
}

// Steps from one jump to the next and records the states at the times of the grid.
class Run {
  public:
    explicit Run(const RunRequest& request)
        : request_(request),
          system_(request),
          method_(make_method(request, system_)),
          y_(system_.dim()),
          dense_(method_->dense_order() > 0),
          steps_unchecked_(std::clamp(512L / request.robot.n, 1L, 64L)),
          unchecked_(steps_unchecked_),
          due_(recorded(1)) {
        if (request.record_energy && dense_) positive_.emplace(system_, *method_);
    }

    RunResult run() {
        system_.write_state(start_chain(request_), y_.data());
        system_.fill_chain(0, y_.data());
        system_.latch();
        begin(0);
        record(0);
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
        method_->restart(t, y_.data());
    }
    void smooth_part(double stop) {
        for (bool more = true; more;) {
            // without dense output the steps must end on what is recorded
            const double limit = dense_ ? stop : std::min(stop, due_);
            const char* failure = method_->step(limit);
            const double t = method_->time();
            more = t < stop;
            if (failure) return give_up(t, failure);
            if (const double e = method_->local_error(); e == e) result_.error += e;
            ++result_.steps;
            if (positive_) positive_->step();
            if (--unchecked_ == 0 && !checked(t)) return;
            if (due_ <= t && !record_until(t)) return;
        }
        std::copy_n(method_->state(), y_.size(), y_.begin());
    }

    // The k-th recorded time: the end comes last.
    double recorded(long k) const {
        const long long step = k * request_.record_steps;
        return step >= request_.steps ? request_.duration : static_cast<double>(step) * request_.dt;
    }
    bool record_until(double t) {
        if (!checked(t)) return false;
        for (; !done_ && due_ <= t; due_ = recorded(++next_)) {
            const double row_time = due_;
            if (row_time == t)
                std::copy_n(method_->state(), y_.size(), y_.begin());
            else
                method_->dense(row_time, y_.data());
            record(row_time);
            done_ = row_time >= request_.duration;
        }
        return true;
    }
    bool checked(double t) {
        unchecked_ = steps_unchecked_;
        if (!bounded(method_->state(), system_.dim())) {
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

    // One row: the state y_ at t.
    void record(double t) {
        const bool forces = request_.record_joints || request_.record_friction;
        forces ? system_.forces(t, y_.data()) : system_.fill_chain(t, y_.data());
        if (forces) method_->add_friction(system_);
        const Chain& c = system_.chain();
        result_.t.push_back(t);
        append(result_.x, c.x);
        append(result_.y, c.y);
        append(result_.theta, c.theta);
        append(result_.vx, c.vx);
        append(result_.vy, c.vy);
        append(result_.omega, c.omega);
        if (request_.record_joints) {
            append(result_.joint_fx, system_.joints().Fx);
            append(result_.joint_fy, system_.joints().Fy);
            append(result_.joint_torque, system_.joints().T);
        }
        for (int i = 0; request_.record_friction && i < request_.robot.n; ++i) {
            result_.friction_x.push_back(c.fx[i] - request_.robot.m * request_.slope.gx);
            result_.friction_y.push_back(c.fy[i] - request_.robot.m * request_.slope.gy);
        }
        if (request_.record_energy) {
            double row[EnergyLedger::kColumns];
            system_.ledger_row(y_.data(), row);
            if (positive_) row[EnergyLedger::kColumns - 1] = positive_->until(t);
            result_.energy.insert(result_.energy.end(), row, row + EnergyLedger::kColumns);
        }
    }
    void append(std::vector<double>& column, const std::vector<double>& row) const {
        // all rows at once: a column that grows is copied over and over
        const auto rows = static_cast<std::size_t>(request_.steps / request_.record_steps + 2);
        if (column.empty()) column.reserve(rows * row.size());
        column.insert(column.end(), row.begin(), row.end());
    }

    const RunRequest& request_;
    System system_;
    const std::unique_ptr<Method> method_;
    std::optional<PositiveWork> positive_;
    std::vector<double> y_;
    RunResult result_;
    std::chrono::steady_clock::time_point question_time_ = std::chrono::steady_clock::now();
    bool dense_, done_ = false;
    long steps_unchecked_, unchecked_, next_ = 1;
    double due_;
};

}  // namespace

RunResult simulate(const RunRequest& request) { return Run(request).run(); }

}  // namespace serpenoid
