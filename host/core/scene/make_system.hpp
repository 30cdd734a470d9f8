// Makes the system that has the terms of a scene, and the source of its torques.
#pragma once

#include <memory>

#include "drive/torque_source.hpp"
#include "scene/run_request.hpp"
#include "scene/system.hpp"

namespace serpenoid {

std::unique_ptr<System> make_explicit(const RunRequest& request);
std::unique_ptr<System> make_implicit(const RunRequest& request);
std::unique_ptr<System> make_system(const RunRequest& request);
std::unique_ptr<TorqueSource> make_torques(const RunRequest& request);

}  // namespace serpenoid
