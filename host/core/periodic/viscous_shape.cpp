// Nodes and equations of viscous_shape.hpp.
#include "periodic/viscous_shape.hpp"

#include <cmath>

namespace serpenoid {

Vec3 ViscousMotion::between(int element, double x) const {
    constexpr int s = ViscousMesh::kStages;
    const auto weight = ViscousMesh::Rule::get().lagrange(x);
    Vec3 y{};
    for (int k = 0; k < s; ++k)
        for (int i = 0; i < 3; ++i) y[i] += weight[k] * stage[element * s + k][i];
    return y;
}

ViscousShape::ViscousShape(const Robot& r, const Ground& g, const Gait& q)
    : robot(r), ground(g), gait(q), mirrored(q.offset == 0), table(r.n, q) {}

ViscousNode ViscousShape::node(double tau) const {
    ViscousNode k{};
    k.shape.set(robot, table, std::sin(tau), std::cos(tau), true);
    k.J = k.shape.J, k.K = k.shape.K;
    static_cast<ViscousSums&>(k) = ViscousSums(k.shape, ground);
    return k;
}

const ViscousMesh& ViscousShape::mesh(int elements) {
    ViscousMesh& m = meshes_[elements];
    if (!m.nodes.empty()) return m;
    m.elements = elements;
    m.h = (mirrored ? M_PI : 2 * M_PI) / elements;
    const auto& rule = ViscousMesh::Rule::get();
    for (int e = 0; e < elements; ++e)
        for (const double c : rule.c) m.nodes.push_back(node((e + c) * m.h));
    return m;
}

Vec3 ViscousShape::derivative(const ViscousNode& k, const Vec3& y, double omega, Mat3& A) const {
    const Vec3 u = velocity(k, y, omega), drag = k.drag(u, omega);
    const double w = u[2], iJ = 1 / k.J, io = 1 / omega, inm = io / (robot.n * robot.m);
    A = {-k.D[0] * inm,          -k.D[1] * inm + w * io, (-k.D[2] * inm + y[1] * io) * iJ,
         -k.D[1] * inm - w * io, -k.D[3] * inm,          (-k.D[4] * inm - y[0] * io) * iJ,
         -k.D[2] * io,           -k.D[4] * io,           -k.D[5] * io * iJ};
    return {-drag[0] * inm + w * y[1] * io, -drag[1] * inm - w * y[0] * io, -drag[2] * io};
}

}  // namespace serpenoid
