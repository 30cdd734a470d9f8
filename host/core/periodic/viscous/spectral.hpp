// Periodic states on viscous ground for many rates of one shape: collocation at equally spaced
// phases, with SIMD batches of rates.
//
// With g = 1/omega, v = V/omega, nu = w/omega (body_shape.hpp has V, w, D, d, J, K), ' by phase:
//
//     v'  = -g (D (v, nu) + d)_xy / nm + nu (v_y, -v_x),
//     nu' = -g (D (v, nu) + d)_w / J - (J' nu + K') / J.
//
// A gait that does not steer has v_x even and v_y, nu odd (spectral_mesh.hpp), so N nodes of half a
// cycle hold three unknowns each. What the modes resolve is exact to the last digit, at the nodes
// and not only in means: |P_i|, which has kinks, can be integrated from them.
//
// Newton's method would need a matrix of 3N each step. Instead: the change d of an iterate obeys
// d' = A d + r, with r = f - y' its residual; Hermite's rule of fourth order
//     d_1 - d_0 = integral r + h/2 [A d]_0^1 (sum) - h^2/12 [(A' + A^2) d + A r]_0^1 (difference)
// gives d from node to node by matrices of three. It approximates tan(z/2) by (z/2)/(1 - z^2/12),
// which holds for all modes of the mesh, and is stable at any decay rate. The iteration converges
// to the collocation's solution, one to three decades each step.
//
// Means are sums over nodes. The error of a mesh is its change from the mesh of half as many nodes,
// times the factor by which the last modes have shrunk between both.
#pragma once

#include <array>
#include <vector>

#include "model/gait.hpp"
#include "model/params.hpp"
#include "periodic/periodic_state.hpp"
#include "periodic/viscous/cycle_table.hpp"
#include "periodic/viscous/pack_memory.hpp"
#include "periodic/viscous/spectral_mesh.hpp"

namespace serpenoid {

class SpectralViscous {
  public:
    // The gait must not steer (offset 0).
    SpectralViscous(const Robot& robot, const Ground& ground, const Gait& gait);

    static constexpr int kWidth = 2;  // of a batch

    // States at up to kWidth rates. Where `converged` is false the state has no meaning: no mesh
    // resolved the motion, or it is too stiff for the multiplier.
    void solve(const double* omega, int count, const SteadyOptions& options, SteadyState* to);

  private:
    static constexpr int kCoarse = 3 * SpectralMesh::kCoarsest;  // unknowns of the coarsest mesh
    static constexpr int kSeeds = 8;
    // Tables of the shape on a mesh.
    struct Level {
        double *node = nullptr, *joint = nullptr;
        std::vector<JointTurn> turns;
        bool powers = false;
        double stiffest = 0;  // largest sum of decay rates, times omega
    };
    // The result of a level for one gait; residual_error: of the state, relative.
    struct Solution {
        double speed, power, still_power, abs_power, abs_error, tail, change, residual_error,
            log_radius, heading;
        std::array<double, 9> transfer;
        int iterations;
    };
    using Batch = std::array<Solution, kWidth>;

    // A solved rate to start others from, with its weight in Lagrange's polynomial.
    struct Seed {
        double log_omega, weight;
    };

    void guess(const double* omega);
    void remember(const double* omega, int count);
    void tables(int level, bool powers);
    std::vector<JointTurn> turns(int level) const;
    bool iterate(int level, double enough, bool first, Batch& found);
    void evaluate(int level, bool powers, const double* omega, Batch& found);
    bool settle(int level, const double* omega, int count, const SteadyOptions& options,
                const Batch& coarse, Batch& found, SteadyState* to);
    SteadyState state_of(int level, const SteadyOptions& options, double omega,
                         const Solution& coarse, const Solution& fine, int lane) const;
    bool multipliers(int level, double omega, const Solution& coarse, const Solution& fine,
                     SteadyState& to) const;
    CycleTask task(int level) const;

    Robot robot_;
    Ground ground_;
    GaitTable table_;
    double alpha_;
    std::array<Level, SpectralMesh::kLevels> level_;
    std::array<Seed, kSeeds> seeds_;
    int seed_count_ = 0;
    PackMemory memory_;
    double *y_, *seed_y_, *g_, *out_, *work_ = nullptr;  // seed_y_: on the coarsest mesh
    int work_nodes_ = 0;
};

}  // namespace serpenoid
