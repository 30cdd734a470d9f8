// A run in time: composed, stepped by its method, recorded.
#pragma once

#include "scene/run_request.hpp"

namespace serpenoid {

RunResult simulate(const RunRequest& request);

}  // namespace serpenoid
