// A piece of the motion on dry ground during which every wheel keeps its mode: it slides forwards,
// slides backwards, or sticks. The joint angles are imposed; the ground is flat.
//
// With p = (nm Vx, nm Vy, L) and u = (Vx, Vy, w) of body_shape.hpp the motion obeys, by phase,
//
//     omega p' = -(D u + omega d) - sum_sliding mu s g - sum_stuck lambda g + w (p_y, -p_x, 0),
//     g_a . u + omega e_a = 0 for every stuck wheel a,
//
// g and e being a wheel's row. For a ratchet, D is that of the mode, mu the mean of its dry
// friction forwards and backwards, and half their difference is a constant thrust along its links.
//
// The piece is solved by Radau collocation (radau_collocation.hpp): p is a polynomial that
// satisfies at every stage the constraints, and the part of the first equation without lambda. So
// there are three unknowns a stage, whatever the number of stuck wheels. The other part of that
// equation gives lambda. Newton's matrix also gives the derivative by the start, and the polynomial
// gives the state between the stages, where a mode may end.
#pragma once

#include <array>
#include <vector>

#include "model/friction_law.hpp"
#include "model/gait.hpp"
#include "model/params.hpp"
#include "numerics/dense.hpp"
#include "numerics/radau_collocation.hpp"
#include "periodic/pieces/stage_shape.hpp"

namespace serpenoid {

// What wheel 2i (along link i) and 2i + 1 (across it) do: sign of sliding, or 0 where it sticks.
struct SlidingMode {
    std::vector<double> sign;
    std::array<int, 3> stuck{};
    int count = 0;  // number of stuck wheels
    bool operator==(const SlidingMode&) const = default;
};

class SlidingPiece {
  public:
    static constexpr int kStages = 5;
    using Rule = RadauRule<kStages>;

    // One phase: sums over the wheels, and the moments J and K of body_shape.hpp.
    struct Node : StageSums {
        double J, K, inverse_J;
    };

    SlidingPiece(const Robot& robot, const Ground& ground, const Gait& gait);
    SlidingPiece(const SlidingPiece&) = delete;
    SlidingPiece& operator=(const SlidingPiece&) = delete;

    // Put nodes 0 and 1 at these phases; their sums need the wheels' directions, so they follow.
    // direction: every wheel's speed, of which the sign counts.
    void set_nodes(double tau0, double tau1);
    void sum_nodes(const std::vector<double>& direction);

    int wheels() const { return 2 * robot_.n; }
    const Node& node(int j) const { return node_[j]; }
    WheelDirection row(int wheel, int j) const { return stages_.row(wheel, j); }
    Vec3 velocity(const Node& node, const Vec3& p) const {
        return {p[0] * inverse_nm_, p[1] * inverse_nm_, (p[2] - omega_ * node.K) * node.inverse_J};
    }
    const WheelLaw& law(int wheel) const { return law_[wheel % 2]; }
    bool has_modes() const { return law_[0].has_modes() || law_[1].has_modes(); }
    // Dry friction over the force that typically acts on a stuck wheel.
    double breakaway_ratio(int wheel) const { return wheel % 2 ? 1 : breakaway_ratio_; }

    // The change of p, least in kinetic energy, that brings the stuck wheels of a mode to rest at a
    // node where the velocity is u.
    Vec3 correction(int node, const SlidingMode& mode, const Vec3& u) const;

    // Solve from phase tau to tau + h. False if Newton's steps do not fall below the tolerance, a
    // fraction of the scales of p.
    bool solve(const SlidingMode& mode, double tau, double h, const Vec3& p0, const Vec3& scale,
               double tolerance);

    double error(const Vec3& scale);         // estimate, as a fraction of the scales; sets drift()
    double drift() const { return drift_; }  // largest speed of stuck wheels, m/s
    Vec3 momenta(double x) const;            // p at a fraction of the piece
    Vec3 rate(double x) const;               // and dp/dtau
    Mat3 tangent(double x) const;            // dp(x)/dp0
    double stuck_force(int a, double x) const;  // lambda of the a-th stuck wheel

    const Vec3& stage(int j) const { return Y_[j]; }
    const Vec3& velocity_at(int node) const { return u_[node]; }  // node 0: start; then stages
    const Mat3& stage_tangent(int j) const { return T_[j]; }
    double stage_force(int j, int a) const { return lambda_[j][a]; }
    // Every wheel's speed at the start and the stages.
    void speeds(Lanes* wheel_speeds) const;
    // A wheel's speed at a fraction of the piece, by the shape there.
    double speed(int wheel, double x);
    // A lower bound, on the piece, of each wheel's polynomial through values at start and stages.
    void lower_bounds(const Lanes* values, double* bounds) const;
    // Every joint's torque and rate at some fractions of the piece.
    void torques(int count, const double* x, Lanes* torque, Lanes* rate);

  private:
    static constexpr int s = kStages, N = 3 * s;
    void set_shapes(int lanes, const Lanes& tau);
    void sum_wheels(int lanes, const std::vector<double>& direction);
    Vec3 free_rate(const Node& node, const Vec3& p, const Vec3& u) const;
    Mat3 free_jacobian(const Node& node, const Vec3& p, const Vec3& u) const;
    bool newton_step();
    void set_stuck_forces();
    Vec3 stage_rate(int j) const;
    std::array<Vec3, 3> equation_directions(int j) const;
    Vec3 direction(int wheel, int j) const;

    Robot robot_;
    double omega_, nm_, inverse_nm_;
    std::array<WheelLaw, 2> law_;  // along links, across them
    double breakaway_ratio_;
    GaitTable table_;
    StageShape stages_;  // at the start, the stages, and a phase between them
    BodyShape scratch_shape_;
    std::vector<double> viscous_, dry_;  // every wheel's coefficient, and force where it slides
    std::vector<Lanes> force_;
    std::array<Node, Lanes::kCount> node_;
    const SlidingMode* mode_ = nullptr;
    double tau_ = 0, h_ = 0;
    Vec3 p0_{};
    std::array<Vec3, kStages> Y_{};      // p at the stages
    std::array<Vec3, kStages + 1> u_{};  // u at the start and the stages
    std::array<Mat3, kStages> T_{};      // dp/dp0 at the stages
    std::array<Vec3, kStages> lambda_{};
    Vec3 change_{};  // largest |change of p| over the stages in the last Newton step
    double drift_ = 0;
};

}  // namespace serpenoid
