// Periodic states on viscous ground for two rates of one shape at a time: collocation at equally
// spaced phases.
//
// With g = 1/omega, v = V/omega, nu = w/omega (body_shape.hpp has V, w, D, d, J, K), ' by phase:
//
//     v'  = -g (D (v, nu) + d)_xy / nm + nu (v_y, -v_x),
//     nu' = -g (D (v, nu) + d)_w / J - (J' nu + K') / J.
//
// A gait that does not steer has v_x even and v_y, nu odd (spectral_mesh.hpp), so N nodes of half a
// cycle hold three unknowns each. What the modes resolve is exact to the last digit, at the nodes
// and not only in means: |P_i|, which has kinks, can be integrated from them (torque_series.hpp).
//
// Newton's method would need a matrix of 3N each step. Instead: the change d of an iterate obeys
// d' = A d + r, with r = f - y' its residual; Hermite's rule of fourth order
//     d_1 - d_0 = integral r + h/2 [A d]_0^1 (sum) - h^2/12 [(A' + A^2) d + A r]_0^1 (difference)
// gives d from node to node by matrices of three. It approximates tan(z/2) by (z/2)/(1 - z^2/12),
// which holds for all modes of the mesh, and is stable at any decay rate. The iteration converges
// to the collocation's solution, one to three decades each step.
//
// Means are sums over nodes. The error of a mesh is its change from the mesh of half as many nodes,
// times the relative change of the motion between both: twice as many modes square its error.
#pragma once

#include "periodic/periodic_state.hpp"
#include "periodic/viscous/cycle_newton.hpp"

namespace serpenoid {

class SpectralViscous {
  public:
    // The gait must not steer (offset 0).
    SpectralViscous(const Robot& robot, const Ground& ground, const Gait& gait)
        : robot_(robot),
          ground_(ground),
          alpha_(gait.alpha),
          table_(robot.n, gait),
          newton_(robot.n * robot.m) {}

    // States at up to kPack rates. Where `converged` is false the state has no meaning: no mesh
    // resolved the motion, or its multiplier.
    void solve(const double* omega, int count, const SteadyOptions& options, SteadyState* states);

  private:
    // The result of a mesh for one gait. Of the motion, relative: change by Newton's first step on
    // the mesh and by the last one, and the error that steps are missing.
    struct Solution {
        double speed, heading, power, still_power, abs_power, abs_error;
        double first_change, change, residual;
        Mat3 transfer;
    };
    using Batch = std::array<Solution, kPack>;

    bool iterate(double enough, Batch& batch);
    void evaluate(bool powers, Batch& batch);
    void add_powers(Batch& batch);
    SteadyState state_of(const SteadyOptions& options, const Solution& coarse, const Solution& fine,
                         int lane) const;

    Robot robot_;
    Ground ground_;
    double alpha_;
    GaitTable table_;
    std::array<std::vector<CycleNode>, SpectralMesh::kLevels> nodes_;
    CycleNewton newton_;
    int level_ = 0;
    Pack omega_{};
    // the motions of the last rates on the coarsest mesh
    std::vector<PackVec> last_ = std::vector<PackVec>(SpectralMesh::kCoarsest);
};

}  // namespace serpenoid
