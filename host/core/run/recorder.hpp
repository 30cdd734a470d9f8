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
    Recorder(const RunRequest& q, System& system, Method& method, const PositiveWork* positive)
        : q_(q), system_(system), method_(method), positive_(positive) {}

    void note(double t, const double* y, RunResult& out) {
        const bool forces = q_.record_joints || q_.record_friction;
        forces ? system_.forces(t, y) : system_.fill(t, y);
        if (forces) method_.give_forces(system_);
        const Chain& c = system_.chain();
        out.t.push_back(t);
        append(out.x, c.x), append(out.y, c.y), append(out.theta, c.theta);
        append(out.vx, c.vx), append(out.vy, c.vy), append(out.omega, c.omega);
        if (q_.record_joints) joints(out);
        if (q_.record_friction) friction(out);
        if (q_.record_energy) {
            double row[EnergyLedger::kColumns];
            system_.ledger_row(y, row);
            if (positive_) row[EnergyLedger::kColumns - 1] = positive_->until(t);
            out.energy.insert(out.energy.end(), row, row + EnergyLedger::kColumns);
        }
    }

  private:
    static void append(std::vector<double>& to, const std::vector<double>& row) {
        to.insert(to.end(), row.begin(), row.end());
    }
    void joints(RunResult& out) const {
        append(out.joint_fx, system_.joints().Fx), append(out.joint_fy, system_.joints().Fy);
        append(out.joint_torque, system_.joints().T);
    }
    void friction(RunResult& out) const {
        for (int i = 0; i < q_.robot.n; ++i) {
            out.friction_x.push_back(system_.chain().fx[i] - q_.robot.m * q_.slope.gx);
            out.friction_y.push_back(system_.chain().fy[i] - q_.robot.m * q_.slope.gy);
        }
    }
    const RunRequest& q_;
    System& system_;
    Method& method_;
    const PositiveWork* positive_;
};

}  // namespace serpenoid
