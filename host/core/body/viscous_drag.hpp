// Viscous friction of the whole chain at a given shape, as sums over its wheels.
#pragma once

#include "body/body_shape.hpp"
#include "model/params.hpp"
#include "numerics/dense.hpp"

namespace serpenoid {

// The friction force and moment on the chain, in the body frame of body_shape.hpp, is
// -(D u + omega d) at the velocity u = (Vx, Vy, w). It dissipates the power
// u.D u + 2 omega d.u + omega^2 dd.
template <class Real>
struct ViscousSumsOf {
    Real D[6] = {};  // upper triangle of a symmetric matrix: xx xy xw yy yw ww
    Real d[3] = {}, dd{};

    ViscousSumsOf() = default;
    ViscousSumsOf(const BodyShapeOf<Real>& shape, const Ground& ground) {
        for (const auto& link : shape.link) {
            add(link.t, ground.along.c);
            add(link.n, ground.across.c);
        }
    }

    // Add a wheel of direction g and viscous coefficient c.
    void add(const DirectionOf<Real>& g, double c) {
        D[0] += c * g.x * g.x;
        D[1] += c * g.x * g.y;
        D[2] += c * g.x * g.r;
        D[3] += c * g.y * g.y;
        D[4] += c * g.y * g.r;
        D[5] += c * g.r * g.r;
        d[0] += c * g.x * g.e;
        d[1] += c * g.y * g.e;
        d[2] += c * g.r * g.e;
        dd += c * g.e * g.e;
    }

    // D u + omega d: the force and moment against the motion.
    std::array<Real, 3> drag(const std::array<Real, 3>& u, double omega) const {
        return {D[0] * u[0] + D[1] * u[1] + D[2] * u[2] + omega * d[0],
                D[1] * u[0] + D[3] * u[1] + D[4] * u[2] + omega * d[1],
                D[2] * u[0] + D[4] * u[1] + D[5] * u[2] + omega * d[2]};
    }

    // Dissipated power, W.
    Real dissipation(const std::array<Real, 3>& u, double omega) const {
        const std::array<Real, 3> f = drag(u, omega);
        return f[0] * u[0] + f[1] * u[1] + f[2] * u[2] +
               omega * (d[0] * u[0] + d[1] * u[1] + d[2] * u[2] + omega * dd);
    }
};
using ViscousSums = ViscousSumsOf<double>;

}  // namespace serpenoid
