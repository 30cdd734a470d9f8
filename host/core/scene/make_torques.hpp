// Make the source of the joints' torques.
#pragma once

#include <memory>

#include "drive/torque_source.hpp"
#include "scene/run_request.hpp"

namespace serpenoid {

std::unique_ptr<TorqueSource> make_torques(const RunRequest& request);

}  // namespace serpenoid
