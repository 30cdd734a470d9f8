// Means over a period of a motion on viscous ground: speed, turn, powers.
#pragma once

#include <vector>

#include "periodic/periodic_state.hpp"
#include "periodic/viscous_shape.hpp"

namespace serpenoid {

// Fill speed, chord, direction, turn and net power.
void set_means(const ViscousShape& shape, const ViscousMotion& motion, SteadyState& out);

// The part of every element in the mean of P_i^+ of every joint, joint by joint.
std::vector<double> positive_powers(const ViscousShape& shape, const ViscousMotion& motion);

// Fill positive and absolute power from such parts, and their error from those of the coarser mesh
// before, if there are any.
void set_positive(const std::vector<double>& fine, const std::vector<double>& coarse,
                  SteadyState& out);

}  // namespace serpenoid
