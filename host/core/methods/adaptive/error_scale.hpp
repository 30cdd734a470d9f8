// The scale of each entry of a system's state, for error norms.
#pragma once

#include <cmath>
#include <vector>

#include "scene/system.hpp"

namespace serpenoid {

// Body lengths (m), radians, and these times `rate` (1/s), whatever the layout of the state: the
// system packs a chain that has these values everywhere, then one in which neighbours differ by
// them, for states that hold joint angles. Entries that are neither are the ledger's: they choose
// no steps, or the motion would depend on what is recorded.
inline std::vector<double> error_scale(const System& system, double body, double rate) {
    Chain probe = system.chain;
    std::vector<double> scale(system.dim()), joints(system.dim());
    for (int i = 0; i < probe.n(); ++i) {
        probe.x[i] = probe.y[i] = body, probe.vx[i] = probe.vy[i] = body * rate;
        probe.theta[i] = 1, probe.omega[i] = rate;
    }
    system.set(probe, scale.data());
    for (int i = 1; i < probe.n(); i += 2) probe.theta[i] = 2, probe.omega[i] = 2 * rate;
    system.set(probe, joints.data());
    for (std::size_t i = 0; i < scale.size(); ++i) {
        if (scale[i] == 0) scale[i] = std::fabs(joints[i]);
        if (scale[i] == 0) scale[i] = HUGE_VAL;
    }
    return scale;
}

}  // namespace serpenoid
