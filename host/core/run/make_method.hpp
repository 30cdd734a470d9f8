// From the name of a method to the one that steps a system.
#pragma once

#include <memory>

#include "methods/method.hpp"
#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

std::unique_ptr<Method> make_method(const RunRequest& request, System& system);

}  // namespace serpenoid
