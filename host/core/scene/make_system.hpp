// From what a scene has to the one system that is compiled with exactly that.
#pragma once

#include <memory>

#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

std::unique_ptr<System> make_explicit(const RunRequest& request);
std::unique_ptr<System> make_implicit(const RunRequest& request);
std::unique_ptr<System> make_system(const RunRequest& request);

}  // namespace serpenoid
