// The classical Runge-Kutta method for the implicit model with imposed angles, by the vector
// kernels.
#pragma once

#include <vector>

#include "kernels/packed_run.hpp"
#include "methods/fixed_step.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

class Rk4Vector final : public FixedStep {
  public:
    // Whether the kernels have all that a scene asks for.
    static bool runs(const RunRequest& q) {
        return q.method.is("rk4") && q.formulation == Formulation::implicit &&
               q.drive == Drive::angle && q.faults.empty() && !q.record_energy;
    }

    Rk4Vector(System& system, const RunRequest& q)
        : FixedStep(system, q.dt),
          run_(q.robot, q.ground, q.spring, q.slope, q.smoothing, q.gait),
          y_(run_.dim()) {}

    void restart(double t, const double* y) override {
        FixedStep::restart(t, y);
        run_.set(y);
    }
    // The state stays with the kernel until somebody asks.
    const double* state() const override {
        run_.get(y_.data());
        return y_.data();
    }
    void dense(double, double* y) const override { run_.get(y); }

  protected:
    // t + dt is the end of the step to the bit: t and it are less than a factor 2 apart, or t = 0.
    void advance(double t, double dt, double*) override { run_.step(t, t + dt); }

  private:
    PackedRun run_;
    mutable std::vector<double> y_;
};

}  // namespace serpenoid
