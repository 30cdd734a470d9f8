// The acceptance of periodic_state.hpp.
#include "periodic/periodic_state.hpp"

#include <algorithm>
#include <cmath>

namespace serpenoid {

SteadyState SteadyState::unknown() {
    SteadyState s;
    s.speed_error = s.power_error = s.positive_power_error = s.turn_error = HUGE_VAL;
    return s;
}

Acceptance::Acceptance(const SteadyOptions& options, const Robot& robot, const Ground& ground,
                       double omega)
    : rtol(options.rtol), power_rtol(ground.smooth() ? rtol : 10 * rtol) {
    // Rounding of a speed is 1e-13 of body length times omega.
    speed_floor = std::max(kSpeedFloor, 1e-13 / rtol) * omega * 2 * robot.l * robot.n;
}

double Acceptance::excess(const SteadyState& s) const {
    const double watts = power_rtol * std::max(s.power, s.positive_power) + 1e-300;
    return std::max(s.speed_error / (rtol * std::max(s.speed, speed_floor)), s.power_error / watts);
}

}  // namespace serpenoid
