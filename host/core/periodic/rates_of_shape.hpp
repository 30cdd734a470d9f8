// Periodic states of one shape of gait on viscous ground, at any rates.
#pragma once

#include <optional>

#include "periodic/steady.hpp"
#include "periodic/viscous/spectral.hpp"

namespace serpenoid {

// Viscous ground: by packs, and by pieces what no pack resolves or steers.
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
