// The classical Runge-Kutta method of order 4 with a fixed step.
#pragma once

#include <vector>

namespace serpenoid {

class Rk4 {
  public:
    explicit Rk4(int dim) : k1_(dim), k2_(dim), k3_(dim), k4_(dim), z_(dim) {}

    // Advance y from t by dt; rate(t, y, dydt) is the right-hand side.
    template <class Rate>
    void step(const Rate& rate, double t, double dt, std::vector<double>& y) {
        const std::size_t n = y.size();
        rate(t, y.data(), k1_.data());
        for (std::size_t i = 0; i < n; ++i) z_[i] = y[i] + dt / 2 * k1_[i];
        rate(t + dt / 2, z_.data(), k2_.data());
        for (std::size_t i = 0; i < n; ++i) z_[i] = y[i] + dt / 2 * k2_[i];
        rate(t + dt / 2, z_.data(), k3_.data());
        for (std::size_t i = 0; i < n; ++i) z_[i] = y[i] + dt * k3_[i];
        rate(t + dt, z_.data(), k4_.data());
        for (std::size_t i = 0; i < n; ++i)
            y[i] += dt / 6 * (k1_[i] + 2 * (k2_[i] + k3_[i]) + k4_[i]);
    }

  private:
    std::vector<double> k1_, k2_, k3_, k4_, z_;
};

}  // namespace serpenoid
