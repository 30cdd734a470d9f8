// Error bounds and acceptance of periodic_state.hpp.
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
    constexpr double kRounding = 1e-13;  // a speed's, over body length times omega
    speed_floor = std::max(kSpeedFloor, kRounding / rtol) * omega * 2 * robot.l * robot.n;
}

double Acceptance::excess(const SteadyState& s) const {
    const double watts = power_rtol * std::max(s.power, s.positive_power) + 1e-300;
    return std::max(s.speed_error / (rtol * std::max(s.speed, speed_floor)), s.power_error / watts);
}

LevelChange::LevelChange(const SteadyState& fine, const SteadyState& coarse)
    : speed(std::fabs(fine.speed - coarse.speed)),
      power(std::fabs(fine.power - coarse.power)),
      turn(std::fabs(fine.turn - coarse.turn)),
      // logarithms, either of which may be that of zero
      slowest(fine.slowest == coarse.slowest ? 0 : std::fabs(fine.slowest - coarse.slowest)) {}

void bound_errors(const LevelChange& change, const LevelChange& before, const ErrorRule& rule,
                  double rtol, SteadyState& s) {
    const auto bound = [&](double now, double earlier, double by_state, double value) {
        const double seen = rule.shrinks * now + earlier + by_state;
        return least_bound(seen, rtol, value);
    };
    s.speed_error = bound(change.speed, rule.earlier * before.speed, rule.speed, s.speed);
    s.power_error = bound(change.power, rule.earlier * before.power, rule.power, s.power);
    s.turn_error =
        std::max(bound(change.turn, rule.earlier * before.turn, rule.turn, s.turn), 1e-14);
    s.positive_power_error = least_bound(s.positive_power_error, rtol, s.positive_power);
}

}  // namespace serpenoid
