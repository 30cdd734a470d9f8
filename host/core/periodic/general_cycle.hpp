// The map of a cycle by a run in time (mode_steps.hpp): slower than smooth pieces, for motions
// that these cannot follow. Its derivative is measured by differences.
#pragma once

#include "periodic/cycle_map.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

class GeneralCycle : public CycleMap {
  public:
    // most_steps: of all cycles together.
    GeneralCycle(const Robot& robot, const Ground& ground, const Gait& gait, long most_steps);

    std::optional<CycleEnd> follow(const Vec3& p, const Following& how) override;
    bool measures_derivative() const override { return true; }
    std::optional<Mat3> measured_derivative(const Vec3& p, const Following& how,
                                            double distance) override;

  private:
    std::optional<CycleEnd> run(const Vec3& p, const Following& how);

    RunRequest request_;
    long steps_ = 0, most_steps_;
};

}  // namespace serpenoid
