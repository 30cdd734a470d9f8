// The classical Runge-Kutta method of order 4 with a fixed step.
#pragma once

#include <vector>

#include "methods/fixed_step.hpp"

namespace serpenoid {

class Rk4 : public FixedStep {
  public:
    Rk4(System& system, double dt)
        : FixedStep(system, dt),
          k1_(system.dim()),
          k2_(system.dim()),
          k3_(system.dim()),
          k4_(system.dim()),
          z_(system.dim()) {}

  protected:
    void advance(double t, double dt, double* y) override {
        const std::size_t n = z_.size();
        system_.rate(t, y, k1_.data());
        for (std::size_t i = 0; i < n; ++i) z_[i] = y[i] + dt / 2 * k1_[i];
        system_.rate(t + dt / 2, z_.data(), k2_.data());
        for (std::size_t i = 0; i < n; ++i) z_[i] = y[i] + dt / 2 * k2_[i];
        system_.rate(t + dt / 2, z_.data(), k3_.data());
        for (std::size_t i = 0; i < n; ++i) z_[i] = y[i] + dt * k3_[i];
        system_.rate(t + dt, z_.data(), k4_.data());
        for (std::size_t i = 0; i < n; ++i)
            y[i] += dt / 6 * (k1_[i] + 2 * (k2_[i] + k3_[i]) + k4_[i]);
    }

  private:
    std::vector<double> k1_, k2_, k3_, k4_, z_;
};

}  // namespace serpenoid
