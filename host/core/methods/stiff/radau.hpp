// Radau IIA of order 5 for the implicit model: stiff joints at the cost of the slow motion alone.
#pragma once

#include <memory>

#include "methods/method.hpp"
#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

// Adaptive to request.tolerance; steps of request.dt if that is 0 (for measuring the order). The
// system gives the state's layout and what is to be integrated beside the motion.
std::unique_ptr<Method> make_radau(const RunRequest& request, System& system);

}  // namespace serpenoid
