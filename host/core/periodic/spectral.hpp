// Periodic states on viscous ground for many rates of one shape: collocation at equally spaced
// phases, with packs of rates.
//
// With g = 1/omega, v = V/omega, nu = w/omega (body_shape.hpp has V, w, D, d, J, K), ' by phase:
//
//     v'  = -g (D (v, nu) + d)_xy / nm + nu (v_y, -v_x),
//     nu' = -g (D (v, nu) + d)_w / J - (J' nu + K') / J.
//
// A gait that does not steer has v_x even and v_y, nu odd (spectral_mesh.hpp), so that N nodes of
// half a cycle hold three unknowns each, and what the modes resolve they give to their last digit:
// at the nodes as well, not only in means, so that |P_i|, which has kinks, can be had from them.
//
// Newton's method on it would cost a matrix of 3N each step. The change d of an iterate obeys
// d' = A d + r, with r = f - y' its residual; Hermite's rule of fourth order
//     d_1 - d_0 = integral r + h/2 [A d]_0^1 (sum) - h^2/12 [(A' + A^2) d + A r]_0^1 (difference)
// gives it from node to node by matrices of three (its modes hold up to the last that the nodes
// carry: tan(z/2) is well met by (z/2)/(1 - z^2/12), and what decays at any rate does so), and the
// iteration converges to the collocation's solution, a decade or three each step.
//
// Means are sums over nodes. What a mesh is wrong by is told from the one of half as many nodes:
// less what the last modes have shrunk by from one to the other.
#pragma once

#include <array>
#include <vector>

#include "kernels/gait_batch.hpp"
#include "kernels/kernel_table.hpp"
#include "model/gait.hpp"
#include "model/params.hpp"
#include "numerics/spectral_mesh.hpp"
#include "periodic/pack_memory.hpp"
#include "periodic/periodic_state.hpp"

namespace serpenoid {

class SpectralViscous {
  public:
    // The gait must not steer (offset 0).
    SpectralViscous(const Robot& robot, const Ground& ground, const Gait& gait,
                    const kernels::Set& set = *instruction_sets().front());

    static constexpr int kWidest = 8;
    int width() const { return set_.width; }  // of a pack

    // States at up to `width` rates. Where `converged` is false nothing is to be trusted: no mesh
    // resolved the motion, or it is too stiff for the multiplier.
    void solve(const double* omega, int count, const SteadyOptions& options, SteadyState* to);

  private:
    static constexpr int kCoarse = 3 * SpectralMesh::kCoarsest;  // unknowns of the coarsest mesh
    static constexpr int kKnown = 8;
    // Tables of the shape on a mesh.
    struct Level {
        double *node = nullptr, *joint = nullptr;
        std::vector<kernels::JointTurn> turns;
        bool powers = false;
        double stiffest = 0;  // largest sum of decay rates, times omega
    };
    // What a level found of a gait.
    struct Found {
        double speed, power, still_power, abs_power, abs_error, tail, change, left, log_radius,
            heading;
        std::array<double, 9> transfer;
        int iterations;
    };
    using Pack = std::array<Found, kWidest>;

    // A rate that is solved, with its weight in Lagrange's polynomial.
    struct Known {
        double log_omega, weight;
    };

    void guess(const double* omega);
    void remember(const double* omega, int count);
    void tables(int level, bool powers);
    std::vector<kernels::JointTurn> turns(int level) const;
    bool iterate(int level, double enough, bool first, Pack& found);
    void evaluate(int level, bool powers, const double* omega, Pack& found);
    bool settle(int level, const double* omega, int count, const SteadyOptions& options,
                const Pack& coarse, Pack& found, SteadyState* to);
    SteadyState state_of(int level, const SteadyOptions& options, double omega, const Found& coarse,
                         const Found& fine, int lane) const;
    bool multipliers(int level, double omega, const Found& coarse, const Found& fine,
                     SteadyState& to) const;
    kernels::CycleTask task(int level) const;

    Robot robot_;
    Ground ground_;
    GaitTable table_;
    double alpha_;
    const kernels::Set& set_;
    std::array<Level, SpectralMesh::kLevels> level_;
    std::array<Known, kKnown> known_;
    int known_count_ = 0;
    PackMemory memory_;
    double *y_, *known_y_, *g_, *out_, *work_ = nullptr;  // known_y_: of the coarsest mesh
    int work_nodes_ = 0;
};

}  // namespace serpenoid
