// Records the states of a run at the recorded times.
#pragma once

#include <vector>

#include "methods/method.hpp"
#include "run/positive_work.hpp"
#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

class Recorder {
  public:
    // `positive`: null where there is none.
    Recorder(const RunRequest& request, System& system, Method& method,
             const PositiveWork* positive)
        : request_(request), system_(system), method_(method), positive_(positive) {}

    void note(double t, const double* y, RunResult& result) {
        const bool forces = request_.record_joints || request_.record_friction;
        forces ? system_.forces(t, y) : system_.fill_chain(t, y);
        if (forces) method_.add_friction(system_);
        const Chain& c = system_.chain();
        result.t.push_back(t);
        append(result.x, c.x);
        append(result.y, c.y);
        append(result.theta, c.theta);
        append(result.vx, c.vx);
        append(result.vy, c.vy);
        append(result.omega, c.omega);
        if (request_.record_joints) joints(result);
        if (request_.record_friction) friction(result);
        if (request_.record_energy) {
            double row[EnergyLedger::kColumns];
            system_.ledger_row(y, row);
            if (positive_) row[EnergyLedger::kColumns - 1] = positive_->until(t);
            result.energy.insert(result.energy.end(), row, row + EnergyLedger::kColumns);
        }
    }

  private:
    void append(std::vector<double>& column, const std::vector<double>& row) const {
        // all rows at once: a column that grows is copied over and over
        const auto rows = static_cast<std::size_t>(request_.steps / request_.record_steps + 2);
        if (column.empty()) column.reserve(rows * row.size());
        column.insert(column.end(), row.begin(), row.end());
    }
    void joints(RunResult& result) const {
        append(result.joint_fx, system_.joints().Fx);
        append(result.joint_fy, system_.joints().Fy);
        append(result.joint_torque, system_.joints().T);
    }
    void friction(RunResult& result) const {
        for (int i = 0; i < request_.robot.n; ++i) {
            result.friction_x.push_back(system_.chain().fx[i] -
                                        request_.robot.m * request_.slope.gx);
            result.friction_y.push_back(system_.chain().fy[i] -
                                        request_.robot.m * request_.slope.gy);
        }
    }
    const RunRequest& request_;
    System& system_;
    Method& method_;
    const PositiveWork* positive_;
};

}  // namespace serpenoid
