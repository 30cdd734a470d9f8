// The implicit model with imposed angles under RK4 by the vector kernels.
#pragma once

#include <memory>
#include <vector>

#include "kernels/kernel_table.hpp"
#include "model/implicit_model.hpp"
#include "model/params.hpp"

namespace serpenoid {

// The sets of kernels that this processor runs, the fastest first.
std::vector<const kernels::Set*> instruction_sets();

// One run of the kernels with its memory. States are those of ImplicitAngle (implicit_systems.cpp):
// x, y, vx, vy of every link, n values each, then theta and omega of link 1.
class PackedRun {
  public:
    // smoothing, m/s: above 0 dry friction is smoothed.
    PackedRun(const Robot& robot, const Ground& ground, const JointSpring& spring,
              const Slope& slope, double smoothing, const Gait& gait,
              const kernels::Set& set = *instruction_sets().front());
    PackedRun(const PackedRun&) = delete;
    PackedRun& operator=(const PackedRun&) = delete;

    int dim() const { return 4 * task_.robot.n + 2; }
    void set(const double* y);
    void get(double* y) const;

    // One step from t to `end`.
    void step(double t, double end) { step_(task_, t, end); }

  private:
    struct Free {
        void operator()(double* p) const;
    };
    double& at(int what, int link) const;
    void set_all_lanes(int which, double value) const;
    void take_gait(const Gait& gait);

    kernels::Task task_;
    kernels::Step step_;
    int width_;
    std::unique_ptr<double[], Free> memory_;
};

}  // namespace serpenoid
