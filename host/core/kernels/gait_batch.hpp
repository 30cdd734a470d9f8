// The implicit model with imposed angles under RK4 by the vector kernels: one run, or many gaits.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "kernels/kernel_table.hpp"
#include "model/implicit_model.hpp"
#include "model/params.hpp"

namespace serpenoid {

// The sets of kernels that this processor runs, the fastest first.
std::vector<const kernels::Set*> instruction_sets();

// What all trajectories of a task share.
struct BatchScene {
    Robot robot;
    Ground ground;
    JointSpring spring;
    double smoothing;  // m/s; above 0 dry friction is smoothed
};

// One task of the kernels with its memory; states as ImplicitAngle has them (systems.hpp):
// x, y, vx, vy of every link, n values each, then theta and omega of link 1.
class PackedRuns {
  public:
    // One gait: links side by side. More, at most set.width: gaits side by side.
    PackedRuns(const BatchScene& scene, const std::vector<Gait>& gaits, bool batch,
               const kernels::Set& set);
    PackedRuns(const PackedRuns&) = delete;
    PackedRuns& operator=(const PackedRuns&) = delete;

    int dim() const { return 4 * task_.robot.n + 2; }
    void set(int gait, const double* y);
    void get(int gait, double* y) const;

    // Steps `first`, ..., first + count - 1, the i-th from i dt to (i + 1) dt.
    void advance(double dt, long first, long count) { kernel_.advance(task_, dt, first, count); }
    void step(double t, double end) { kernel_.step(task_, t, end); }

  private:
    struct Free {
        void operator()(double* p) const;
    };
    double& at(int what, int link, int gait) const;
    double& one(int which, int gait) const;
    void take_gait(int lane, const Gait& gait);

    kernels::Task task_;
    kernels::Kernel kernel_;
    int width_;
    bool batch_;
    std::unique_ptr<double[], Free> memory_;
};

// End states of many gaits, and how far each came.
struct GaitEnds {
    std::vector<double> state;    // dim values a gait
    std::vector<double> reached;  // s; below the duration where a run left the finite numbers
};

// Run every gait from its start (dim values each) by steps of dt, the last one to `duration`. Gaits
// run side by side, or one after the other with their links side by side. A gait's numbers do not
// depend on which others run with it.
GaitEnds run_gaits(const BatchScene& scene, const std::vector<Gait>& gaits,
                   const std::vector<double>& starts, double dt, double duration, long steps,
                   const kernels::Set& set, bool batch);

}  // namespace serpenoid
