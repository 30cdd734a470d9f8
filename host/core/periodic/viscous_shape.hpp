// The shape of a gait on viscous ground at the nodes of Gauss collocation, and a motion on it.
//
// The motion is y = (Vx, Vy, L) of body_shape.hpp as a function of the phase tau; viscous.hpp has
// its equations.
#pragma once

#include <map>
#include <vector>

#include "body/body_shape.hpp"
#include "body/viscous_drag.hpp"
#include "numerics/dense.hpp"
#include "numerics/gauss_rule.hpp"

namespace serpenoid {

struct ViscousNode : ViscousSums {
    double J, K;
    BodyShape shape;
};

struct ViscousMesh {
    static constexpr int kStages = 6;
    using Rule = Gauss<kStages>;

    int elements;
    double h;  // phase per element
    std::vector<ViscousNode> nodes;
};

// A motion by its start and its values at the nodes of a mesh.
struct ViscousMotion {
    const ViscousMesh* mesh = nullptr;  // none: nothing is known yet
    double omega = 0;
    Vec3 start{};
    std::vector<Vec3> stage;

    // The state at the fraction x of an element, by its stages.
    Vec3 between(int element, double x) const;
};

// Its tables do not depend on the rate.
class ViscousShape {
  public:
    ViscousShape(const Robot& robot, const Ground& ground, const Gait& gait);

    const ViscousMesh& mesh(int elements);
    ViscousNode node(double tau) const;

    // f = dy/dtau and its derivative by y.
    Vec3 derivative(const ViscousNode& node, const Vec3& y, double omega, Mat3& by_y) const;
    // u = (Vx, Vy, w) of y.
    static Vec3 velocity(const ViscousNode& node, const Vec3& y, double omega) {
        return {y[0], y[1], (y[2] - omega * node.K) / node.J};
    }

    const Robot robot;
    const Ground ground;
    const Gait gait;
    const bool mirrored;  // half a cycle is enough
    const GaitTable table;

  private:
    std::map<int, ViscousMesh> meshes_;
};

}  // namespace serpenoid
