// The choice among the torque sources.
#include "scene/make_torques.hpp"

namespace serpenoid {

std::unique_ptr<TorqueSource> make_torques(const RunRequest& q) {
    if (q.drive == Drive::angle) return std::make_unique<NoTorque>();
    if (q.drive == Drive::servo) return std::make_unique<ServoTorque>(q.servo, q.gait, q.robot.n);
    if (!q.table.empty()) return std::make_unique<TableTorque>(q.table);
    return std::make_unique<FunctionTorque>(q.torque);
}

}  // namespace serpenoid
