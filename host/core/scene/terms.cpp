// The ground force of a scene, for systems that are compiled once.
#include "scene/terms.hpp"

namespace serpenoid {

std::unique_ptr<ChainForce> make_force(const RunRequest& q) {
    return with_force<ChainForce>(q, [&]<class Force>() -> std::unique_ptr<ChainForce> {
        return std::make_unique<Force>(q.ground, q.smoothing, q.slope, q.robot.m);
    });
}

}  // namespace serpenoid
