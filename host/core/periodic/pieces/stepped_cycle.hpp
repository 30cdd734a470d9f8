// The map of a cycle on dry ground by implicit steps (sticking_motion.hpp): slower than smooth
// pieces, for motions that are too stiff for them.
//
// Its derivative is measured by differences and kept up to date by Broyden's rule; where the map
// does not follow it any more it is measured again.
#pragma once

#include "body/sticking_motion.hpp"
#include "periodic/cycle_map.hpp"

namespace serpenoid {

class SteppedCycle : public CycleMap {
  public:
    SteppedCycle(const Robot& robot, const Ground& ground, const Gait& gait, long most_systems);

    std::optional<CycleEnd> follow(const Vec3& p, const Following& how) override;
    bool measures_derivative() const override { return true; }
    std::optional<Mat3> measured_derivative(const Vec3& p, const Following& how,
                                            double distance) override;

  private:
    static constexpr int kRows = CycleState::kRows;
    using Rows = std::array<double, kRows>;  // p, theta, x, y, dissipated
    std::optional<Rows> run(const Vec3& p, const Following& how, double* positive = nullptr);
    bool update(const Vec3& p, const Rows& end, double tolerance);
    bool measure(const Vec3& p, const Rows& end, double tolerance);

    DryMotion motion_;
    std::array<Vec3, kRows> by_start_{};
    Vec3 last_p_{};
    Rows last_end_{};
    double last_tolerance_ = 0;
    bool measured_ = false;
};

}  // namespace serpenoid
