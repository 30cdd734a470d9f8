// Periodic state under viscous friction: collocation in time and Newton's method on all of it.
//
// Unknown is y = (Vx, Vy, L) of body_shape.hpp as a function of the phase tau. With G = -(D u +
// omega d) the friction force and couple on the chain (D, d: sums over wheels, functions of tau
// alone),
//     omega Vx' = G_x/(nm) + w Vy,   omega Vy' = G_y/(nm) - w Vx,   omega L' = G_w,
//     w = (L - omega K)/J.
// Half a cycle later every joint angle has changed sign, so the motion is its own mirror image:
// y(tau + pi) = S y(tau), S = diag(1, -1, -1), and half a cycle is enough (a whole one when the
// gait steers). Elements of Gauss collocation (order 12) cover it; each Newton step eliminates the
// stages element by element, and the product of the transfer matrices is the monodromy matrix.
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "body/body_shape.hpp"
#include "body/viscous_drag.hpp"
#include "numerics/gauss_rule.hpp"
#include "periodic/periodic_state.hpp"

namespace serpenoid {

// Solves for one shape (alpha, beta, offset) and any number of rates: its tables do not hold omega.
class SteadyViscous {
  public:
    SteadyViscous(const Robot& robot, const Ground& ground, const Gait& gait);

    // The periodic state at this rate; starts from the last solution, scaled, when there is one.
    SteadyState solve(double omega, const SteadyOptions& options);

  private:
    static constexpr int kStages = 6;
    using Rule = Gauss<kStages>;

    struct Node : ViscousSums {
        double J, K;
        BodyShape shape;
    };
    struct Mesh {
        int elements;
        double h;  // phase per element
        std::vector<Node> nodes;
    };
    struct Iterate {
        int elements = 0;
        double omega = 0;
        Vec3 start{};
        std::vector<Vec3> stage;
    };

    // A linearised element: its stages as functions of its start (three columns, then what they
    // are off by, a row a component), and the same of its end.
    struct Element {
        std::array<double, 3 * kStages * 4> stages;
        Mat3 transfer;
        Vec3 correction;
    };

    const Mesh& mesh(int elements);
    Node node(double tau) const;
    void guess(const Mesh& mesh, double omega);
    bool newton(const Mesh& mesh, double omega, double enough, SteadyState& result);
    bool eliminate(const Mesh& mesh, int e, double omega, Vec3& y, Element& out) const;
    std::pair<double, double> update(const Mesh& mesh, int e, double omega, const Element& element,
                                     const Vec3& d);
    double newton_step(const Mesh& mesh, double omega, Mat3& half);
    Vec3 derivative(const Node& node, const Vec3& y, double omega, Mat3& jacobian) const;
    void averages(const Mesh& mesh, double omega, SteadyState& result) const;
    Vec3 beginning(const Mesh& mesh, double omega) const;
    Vec3 travel(const Mesh& mesh, double omega, double spin) const;
    std::vector<double> positive_powers(const Mesh& mesh, double omega) const;
    void slowest(const Mesh& mesh, double omega, SteadyState& result) const;
    double followed_slowest(const Mesh& mesh, double omega, int pieces) const;
    Vec3 between(int e, double x) const;
    ErrorRule rule(const LevelChange& change, const LevelChange& before, int meshes) const;
    void bound_slowest(double omega, double rtol, const SteadyState& coarse, SteadyState& s);

    Robot robot_;
    Ground ground_;
    Gait gait_;
    GaitTable table_;
    bool mirrored_;
    std::vector<double> lag_;  // of every joint, rad
    std::map<int, Mesh> meshes_;
    Iterate now_;
};

}  // namespace serpenoid
