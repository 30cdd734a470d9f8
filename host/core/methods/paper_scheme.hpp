// The paper's own scheme, as far as its text tells: Runge-Kutta steps in which the dampers of the
// joints act on the velocities of the step before ("using velocities from the previous time
// steps", below Eq. 56). Order 1. The Simulink model itself is lost; this is its likeliest reading
// (a memory block before the dampers, a fixed-step solver of order 4 around it).
#pragma once

#include "methods/rk4.hpp"

namespace serpenoid {

class PaperScheme : public Rk4 {
  public:
    using Rk4::Rk4;

  protected:
    void advance(double t, double dt, double* y) override {
        next_.assign(y, y + system_.dim());
        Rk4::advance(t, dt, y);
        system_.fill_chain(t, next_.data());
        system_.latch();
    }

  private:
    std::vector<double> next_;
};

}  // namespace serpenoid
