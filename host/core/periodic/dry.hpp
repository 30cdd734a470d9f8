// Periodic state on dry ground: Newton's method on the half-cycle map of sticking_motion.hpp.
#pragma once

#include "periodic/periodic_state.hpp"

namespace serpenoid {

SteadyState steady_dry(const Robot& robot, const Ground& ground, const Gait& gait,
                       const SteadyOptions& options);

}  // namespace serpenoid
