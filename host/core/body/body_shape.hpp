// The shape of the chain at one phase of the gait: everything about it that the motion does not
// change.
//
// Body frame: origin at the centre of mass of the whole chain, x axis along link 1. Its velocity is
// u = (Vx, Vy, w): velocity of the centre of mass in body axes, and w = theta_1'. With rho_i the
// centre of link i in this frame, sigma_i = theta_i - theta_1 and ' = d/dtau (tau = omega t):
//
//     velocity of link i   v_i = V + w z x rho_i + omega rho_i'
//     momentum             nm V   and   L = J w + omega K,
//         J = n I + m sum |rho_i|^2,   K = I sum sigma_i' + m sum rho_i x rho_i'
//
// so the speed of wheel i along and across its link is a row of three numbers times u, plus one
// times omega: v_i^t = t_i . V + (rho_i x t_i) w + omega t_i . rho_i', and likewise for n_i.
#pragma once

#include <vector>

#include "model/gait.hpp"
#include "model/params.hpp"
#include "numerics/pack.hpp"

namespace serpenoid {

// One direction of one wheel: speed = x Vx + y Vy + r w + omega e. Real: double, or a Pack of
// phases.
template <class Real>
struct DirectionOf {
    Real x, y, r, e;
    Real speed(const Real u[3], double omega) const {
        return x * u[0] + y * u[1] + r * u[2] + omega * e;
    }
};
using WheelDirection = DirectionOf<double>;

template <class Real>
struct LinkShapeOf {
    DirectionOf<Real> t, n;  // (t.x, t.y) is the tangent, (n.x, n.y) the normal
    Real rx, ry;             // rho, m
    Real rx1, ry1;           // rho', m/rad
    Real s1;                 // sigma'
    Real rx2, ry2, s2;       // second derivatives, filled only when asked for
};
using LinkShape = LinkShapeOf<double>;

template <class Real>
struct BodyShapeOf {
    std::vector<LinkShapeOf<Real>> link;
    Real J, K;    // kg m^2
    Real J1, K1;  // their derivatives by tau, filled with the second derivatives

    // Fill for one phase, or a pack of them. `second` adds what accelerations need and friction
    // does not.
    void set(const Robot& robot, const GaitTable& gait, Real sin_tau, Real cos_tau, bool second);

  private:
    void chain(double l, const GaitTable& gait, Real sin_tau, Real cos_tau, bool second);
    void centre(bool second);
};
using BodyShape = BodyShapeOf<double>;

template <class Real>
INLINED void BodyShapeOf<Real>::chain(double l, const GaitTable& gait, Real sin_tau, Real cos_tau,
                                      bool second) {
    const int n = gait.joints() + 1;
    link.resize(n);
    Real angle{}, s1{}, s2{}, c = Real{} + 1.0, s{}, x{}, y{}, x1{}, y1{}, x2{}, y2{};
    const auto half = [&] {
        x += l * c;
        y += l * s;
        x1 -= l * s1 * s;
        y1 += l * s1 * c;
        if (second) {
            x2 -= l * (s2 * s + s1 * s1 * c);
            y2 += l * (s2 * c - s1 * s1 * s);
        }
    };
    for (int i = 0;; ++i) {
        LinkShapeOf<Real>& k = link[i];
        k.t.x = c;
        k.t.y = s;
        k.n.x = -s;
        k.n.y = c;
        k.rx = x;
        k.ry = y;
        k.rx1 = x1;
        k.ry1 = y1;
        k.s1 = s1;
        if (second) {
            k.rx2 = x2;
            k.ry2 = y2;
            k.s2 = s2;
        }
        if (i + 1 == n) return;
        half();  // to the joint with the old angle, from the joint on with the new one
        const auto j = gait.joint(i, sin_tau, cos_tau);
        angle += j.angle;
        s1 += j.slope;
        s2 += j.curvature;
        sincos(angle, s, c);
        half();
    }
}

template <class Real>
INLINED void BodyShapeOf<Real>::centre(bool second) {
    Real x{}, y{}, x1{}, y1{}, x2{}, y2{};
    for (const auto& k : link) {
        x += k.rx;
        y += k.ry;
        x1 += k.rx1;
        y1 += k.ry1;
        if (second) {
            x2 += k.rx2;
            y2 += k.ry2;
        }
    }
    const double f = 1.0 / static_cast<double>(link.size());
    for (auto& k : link) {
        k.rx -= f * x;
        k.ry -= f * y;
        k.rx1 -= f * x1;
        k.ry1 -= f * y1;
        if (second) {
            k.rx2 -= f * x2;
            k.ry2 -= f * y2;
        }
        k.t.r = k.rx * k.t.y - k.ry * k.t.x;
        k.t.e = k.t.x * k.rx1 + k.t.y * k.ry1;
        k.n.r = k.rx * k.n.y - k.ry * k.n.x;
        k.n.e = k.n.x * k.rx1 + k.n.y * k.ry1;
    }
}

template <class Real>
INLINED void BodyShapeOf<Real>::set(const Robot& robot, const GaitTable& gait, Real sin_tau,
                                    Real cos_tau, bool second) {
    chain(robot.l, gait, sin_tau, cos_tau, second);
    centre(second);
    Real square{}, cross{}, turn{};
    for (const auto& k : link) {
        square += k.rx * k.rx + k.ry * k.ry;
        cross += k.rx * k.ry1 - k.ry * k.rx1;
        turn += k.s1;
    }
    J = robot.n * robot.I + robot.m * square;
    K = robot.I * turn + robot.m * cross;
    if (!second) return;
    Real dot{}, cross2{}, turn2{};
    for (const auto& k : link) {
        dot += k.rx * k.rx1 + k.ry * k.ry1;
        cross2 += k.rx * k.ry2 - k.ry * k.rx2;
        turn2 += k.s2;
    }
    J1 = 2 * robot.m * dot;
    K1 = robot.I * turn2 + robot.m * cross2;
}

}  // namespace serpenoid
