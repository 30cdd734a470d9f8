// The choice between packs and pieces of rates_of_shape.hpp.
#include "periodic/rates_of_shape.hpp"

#include <algorithm>

namespace serpenoid {

RatesOfShape::RatesOfShape(const Robot& robot, const Ground& ground, const Gait& gait)
    : robot_(robot), ground_(ground), gait_(gait) {
    if (ground.smooth() && gait.offset == 0) packs_.emplace(robot, ground, gait);
}

void RatesOfShape::solve(const double* omega, int count, const SteadyOptions& options,
                         SteadyState* to) {
    const int width = packs_ ? kPack : 1;
    for (int first = 0; first < count; first += width) {
        const int here = std::min(width, count - first);
        if (packs_) packs_->solve(omega + first, here, options, to + first);
        for (int i = first; i < first + here; ++i) {
            if (packs_ && to[i].converged) continue;
            if (!by_pieces_) by_pieces_.emplace(robot_, ground_, gait_);
            to[i] = by_pieces_->solve(omega[i], options);
        }
    }
}

}  // namespace serpenoid
