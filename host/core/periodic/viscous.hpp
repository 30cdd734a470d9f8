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
#include <utility>
#include <vector>

#include "periodic/periodic_state.hpp"
#include "periodic/viscous_shape.hpp"

namespace serpenoid {

// Solves for one shape (alpha, beta, offset) and any number of rates.
class SteadyViscous {
  public:
    SteadyViscous(const Robot& robot, const Ground& ground, const Gait& gait)
        : shape_(robot, ground, gait) {}

    // The periodic state at this rate; starts from the last solution, scaled, when there is one.
    SteadyState solve(double omega, const SteadyOptions& options);

  private:
    static constexpr int kStages = ViscousMesh::kStages;
    using Rule = ViscousMesh::Rule;

    // A linearised element: its stages as functions of its start (three columns, then the
    // correction, a row a component), and the same of its end.
    struct Element {
        std::array<double, 3 * kStages * 4> stages;
        Mat3 transfer;
        Vec3 correction;
    };
    // The linearised end of a mesh: its derivative by the start, and by what y + q is off.
    struct Chain {
        std::vector<Element> elements;
        Mat3 transfer = identity3();
        Vec3 end{};
    };

    void guess(const ViscousMesh& mesh, double omega);
    double newton(double enough, SteadyState& result);
    bool eliminate(int e, Vec3& y, Element& out) const;
    bool linearise(Chain& chain) const;
    std::pair<double, double> update(int e, const Element& element, const Vec3& d);
    double update_all(const Chain& chain, Vec3 d);
    void set_means(SteadyState& out) const;
    ErrorRule rule(const LevelChange& change, const LevelChange& before, int meshes,
                   double left) const;
    void set_slowest(double rtol, const SteadyState& coarse, SteadyState& s) const;

    ViscousShape shape_;
    ViscousMotion now_;
};

}  // namespace serpenoid
