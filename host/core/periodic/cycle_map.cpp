// Scales and the start of cycle_map.hpp.
#include "periodic/cycle_map.hpp"

#include <algorithm>

namespace serpenoid {

CycleMap::CycleMap(const Robot& robot, const Gait& gait)
    : robot_(robot),
      gait_(gait),
      table_(robot.n, gait),
      nm_(robot.n * robot.m),
      mirrored_(gait.offset == 0) {
    constexpr double kLeastBend = 1e-9;  // rad
    const double v = gait.omega * robot.l * std::max(gait.alpha, kLeastBend),
                 arm = robot.n * robot.l;
    scale_ = {nm_ * v, nm_ * v, robot.n * (robot.I + robot.m * arm * arm / 12) * v / arm};
    shape_.set(robot_, table_, 0, 1, false);
}

}  // namespace serpenoid
