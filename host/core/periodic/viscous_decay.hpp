// Fast decay on viscous ground: the slowest multiplier, and the state at phase 0.
#pragma once

#include "periodic/viscous_shape.hpp"

namespace serpenoid {

// The state at phase 0.
Vec3 state_at_start(const ViscousShape& shape, const ViscousMotion& motion);

// Logarithm of the size of a period's largest multiplier, and the period's monodromy matrix.
struct Slowest {
    double log_size, error;  // error 0: that of the collocation
    Mat3 monodromy;
};
Slowest slowest_multiplier(const ViscousShape& shape, const ViscousMotion& motion,
                           const Mat3& monodromy);

}  // namespace serpenoid
