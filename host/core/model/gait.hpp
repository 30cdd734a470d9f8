// The gait formula (Eq. 57) in double precision: the reference that the firmware is held to.
#pragma once

#include <cmath>
#include <vector>

#include "model/params.hpp"

namespace serpenoid {

// The gait at one time: angle, rate and second derivative of every joint. A view of a GaitTable.
struct GaitWave {
    double sin_a, cos_a;      // alpha sin(omega t), alpha cos(omega t)
    double sin_w, cos_w;      // omega times these
    double offset, minus_ww;  // -omega^2
    const double *cos, *sin;  // of i beta + shift_i, times gain_i
    struct Joint {
        double angle, rate, acceleration;  // phi, phi', phi'' by time
    };
    INLINED Joint joint(int i) const {
        const double swing = sin_a * cos[i] + cos_a * sin[i];
        return {offset + swing, cos_w * cos[i] - sin_w * sin[i], minus_ww * swing};
    }
};

// phi_i and its first two derivatives by the phase tau = omega t, for joints 0..n-2.
// sin(tau + i beta) = sin tau cos(i beta) + cos tau sin(i beta), so a time costs one sine pair;
// a joint with a gain or a shift of its own (Gait) has them in its cosine and sine.
class GaitTable {
  public:
    GaitTable(int links, const Gait& g) : alpha_(g.alpha), offset_(g.offset) {
        for (int i = 0; i + 1 < links; ++i) {
            const double gain = g.gain.empty() ? 1 : g.gain[i];
            const double phase = i * g.beta + (g.shift.empty() ? 0 : g.shift[i]);
            cos_.push_back(gain * std::cos(phase));
            sin_.push_back(gain * std::sin(phase));
        }
    }

    template <class Real>
    struct JointOf {
        Real angle, slope, curvature;  // phi, dphi/dtau, d2phi/dtau2
    };
    using Joint = JointOf<double>;

    // At one phase, or a pack of them.
    template <class Real>
    JointOf<Real> joint(int i, Real sin_tau, Real cos_tau) const {
        const Real s = alpha_ * (sin_tau * cos_[i] + cos_tau * sin_[i]);
        const Real c = alpha_ * (cos_tau * cos_[i] - sin_tau * sin_[i]);
        return {offset_ + s, c, -s};
    }

    GaitWave wave(double omega, double t) const {
        return wave(omega, std::sin(omega * t), std::cos(omega * t));
    }
    GaitWave wave(double omega, double sin_tau, double cos_tau) const {
        const double s = alpha_ * sin_tau, c = alpha_ * cos_tau;
        return {s, c, omega * s, omega * c, offset_, -omega * omega, cos_.data(), sin_.data()};
    }

    // gain_i cos(i beta + shift_i), and the sine.
    double cosine(int i) const { return cos_[i]; }
    double sine(int i) const { return sin_[i]; }

    // The angle a for which the i-th joint's swing is a positive factor times alpha sin(tau + a).
    double lag(int i) const { return std::atan2(sin_[i], cos_[i]); }

    int joints() const { return static_cast<int>(cos_.size()); }

  private:
    double alpha_, offset_;
    std::vector<double> cos_, sin_;
};

}  // namespace serpenoid
