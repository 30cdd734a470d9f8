// The gait formula (Eq. 57) in double precision: the reference that the firmware is held to.
#pragma once

#include <cmath>
#include <vector>

#include "params.hpp"

namespace serpenoid {

// phi_i and its first two derivatives by the phase tau = omega t, for joints 0..n-2.
// sin(tau + i beta) = sin tau cos(i beta) + cos tau sin(i beta), so a time costs one sine pair.
class GaitTable {
  public:
    GaitTable(int links, const Gait& g) : alpha_(g.alpha), offset_(g.offset) {
        for (int i = 0; i + 1 < links; ++i) {
            cos_.push_back(std::cos(i * g.beta));
            sin_.push_back(std::sin(i * g.beta));
        }
    }

    struct Joint {
        double angle, rate, curvature;  // phi, dphi/dtau, d2phi/dtau2
    };

    Joint at(int i, double sin_tau, double cos_tau) const {
        const double s = alpha_ * (sin_tau * cos_[i] + cos_tau * sin_[i]);
        const double c = alpha_ * (cos_tau * cos_[i] - sin_tau * sin_[i]);
        return {offset_ + s, c, -s};
    }

    int joints() const { return static_cast<int>(cos_.size()); }

  private:
    double alpha_, offset_;
    std::vector<double> cos_, sin_;
};

}  // namespace serpenoid
