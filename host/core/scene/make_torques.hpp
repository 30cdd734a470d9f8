// From what drives a scene's joints to where their torques come from.
#pragma once

#include <memory>

#include "drive/torque_source.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

std::unique_ptr<TorqueSource> make_torques(const RunRequest& request);

}  // namespace serpenoid
