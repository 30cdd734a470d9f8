// The shape of the chain at up to eight phases, for the pieces of motion on dry ground
// (periodic/dry/sliding_piece.hpp), and the kernels that fill it.
#pragma once

#include "kernels/cycle_table.hpp"

namespace serpenoid::kernels {

struct alignas(64) Lanes {
    static constexpr int kCount = 8;
    double at[kCount];
};

// The directions of one wheel (body_shape.hpp).
struct StageWheel {
    Lanes x, y, r, e;
};

// What is summed over the chain. Friction on it is -(D u + omega d) of the viscous wheels and
// -(dry) of the others' forces, in the body frame; dd and dry_e go with what that dissipates.
struct StageSums {
    Lanes J, K, D[6], d[3], dd, dry[3], dry_e;
};

struct StageKernel {
    // J, K and the wheels, 2i along and 2i + 1 across link i. Scratch: 8 Lanes a link. `lanes`:
    // number of phases that count; the rest of the last pack is filled, too.
    void (*shape)(const CycleChain&, int lanes, const Lanes& tau, StageSums&, StageWheel*,
                  double* scratch);
    // The sums, by every wheel's viscous coefficient and dry force.
    void (*sums)(int wheels, int lanes, const StageWheel*, const double* viscous, const double* dry,
                 StageSums&);
    // Every wheel's speed at u = (Vx, Vy, w).
    void (*speeds)(int wheels, int lanes, const StageWheel*, const Lanes* u, double omega,
                   Lanes* out);
    // The least Bernstein coefficient of each wheel: each is a weighted sum of `points` values.
    void (*lowest)(int wheels, int points, const Lanes* weights, const Lanes* values, double* out);
    // Every joint's torque and rate at such n m Vx, n m Vy, L, by the wheels' coefficients and dry
    // forces.
    void (*torques)(const CycleChain&, int lanes, const Lanes& tau, const Lanes* momenta,
                    double omega, const double* viscous, const Lanes* dry, Lanes* torque,
                    Lanes* rate, double* scratch);
    bool (*solve)(double* rows);  // stage_solve.hpp
};

}  // namespace serpenoid::kernels
