// Periodic states of one shape of gait at any rates, by the solver that the ground allows.
#pragma once

#include <optional>

#include "periodic/steady.hpp"
#include "periodic/viscous/spectral.hpp"

namespace serpenoid {

// On viscous ground by packs, unless none resolves the motion or the gait steers; else by pieces.
class RatesOfShape {
  public:
    RatesOfShape(const Robot& robot, const Ground& ground, const Gait& gait);

    void solve(const double* omega, int count, const SteadyOptions& options, SteadyState* to);

  private:
    Robot robot_;
    Ground ground_;
    Gait gait_;
    std::optional<SpectralViscous> packs_;
    std::optional<SteadyByPieces> by_pieces_;
};

}  // namespace serpenoid
