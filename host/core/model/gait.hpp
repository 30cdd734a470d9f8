// The gait formula (Eq. 57) in double precision; tests compare the firmware with it.
#pragma once

#include <cmath>
#include <vector>

#include "model/params.hpp"

namespace serpenoid {

// Angle, rate and acceleration of every joint at one time. It refers to the arrays of a GaitTable.
struct GaitWave {
    double angle_sin, angle_cos;  // alpha sin(omega t), alpha cos(omega t), rad
    double rate_sin, rate_cos;    // alpha omega sin(omega t), alpha omega cos(omega t), rad/s
    double offset;                // rad
    double minus_omega_squared;   // 1/s^2
    const double *cos, *sin;      // gain_i cos(i beta + shift_i), gain_i sin(i beta + shift_i)
    struct Joint {
        double angle, rate, acceleration;  // phi, dphi/dt, d2phi/dt2; rad, s
    };
    INLINED Joint joint(int i) const {
        const double swing = angle_sin * cos[i] + angle_cos * sin[i];
        return {offset + swing, rate_cos * cos[i] - rate_sin * sin[i], minus_omega_squared * swing};
    }
};

// phi_i and its first two derivatives by the phase tau = omega t, for joints 0..n-2.
// sin(tau + i beta) = sin tau cos(i beta) + cos tau sin(i beta): the table holds the factors of the
// joints, so that one time needs one sine and one cosine. The factors include gain_i and shift_i.
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

    // Joint i at one phase, or at a pack of phases.
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

    // gain_i cos(i beta + shift_i), gain_i sin(i beta + shift_i)
    double cosine(int i) const { return cos_[i]; }
    double sine(int i) const { return sin_[i]; }

    // Phase lead of joint i, rad: its swing is |gain_i| alpha sin(tau + lag).
    double lag(int i) const { return std::atan2(sin_[i], cos_[i]); }

    int joints() const { return static_cast<int>(cos_.size()); }

  private:
    double alpha_, offset_;
    std::vector<double> cos_, sin_;
};

}  // namespace serpenoid
