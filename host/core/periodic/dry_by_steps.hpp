// Periodic state on dry ground by implicit steps: slower than dry.hpp, for what is too stiff for
// it.
#pragma once

#include "periodic/periodic_state.hpp"

namespace serpenoid {

SteadyState steady_dry_by_steps(const Robot& robot, const Ground& ground, const Gait& gait,
                                const SteadyOptions& options);

}  // namespace serpenoid
