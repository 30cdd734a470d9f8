// Mean positive power of one joint over an element of phase, whose joint rate is known by formula.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "numerics/mean_positive_part.hpp"

namespace serpenoid {

// Torque and rate by their values at the Gauss nodes of [tau, tau + h]; the rate goes with
// cos(tau + lag), of which at most one root counts: h is at most pi.
template <int s>
double mean_positive_swing(const std::array<double, s>& torque, const std::array<double, s>& rate,
                           double tau, double h, double lag, double alpha) {
    using std::numbers::pi;
    const double from = tau + lag;
    const double root = pi * (std::ceil(from / pi - 0.5) + 0.5);  // the first at or after it
    const double turn = 2 * (root - from) / h - 1;
    const double before = alpha * std::cos(root - pi / 2);
    return mean_positive_product<s>(torque, rate, turn, before);
}

}  // namespace serpenoid
