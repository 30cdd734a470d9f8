// Make the system that has the terms of a scene.
#pragma once

#include <memory>

#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

std::unique_ptr<System> make_explicit(const RunRequest& request);
std::unique_ptr<System> make_implicit(const RunRequest& request);
std::unique_ptr<System> make_system(const RunRequest& request);

}  // namespace serpenoid
