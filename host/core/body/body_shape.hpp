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

#include <cmath>
#include <vector>

#include "model/gait.hpp"
#include "model/params.hpp"

namespace serpenoid {

// One direction of one wheel: speed = x Vx + y Vy + r w + omega e.
struct WheelDirection {
    double x, y, r, e;
    double speed(const double u[3], double omega) const {
        return x * u[0] + y * u[1] + r * u[2] + omega * e;
    }
};

struct LinkShape {
    WheelDirection t, n;  // (t.x, t.y) is the tangent, (n.x, n.y) the normal
    double rx, ry;        // rho, m
    double rx1, ry1;      // rho', m/rad
    double s1;            // sigma'
    double rx2, ry2, s2;  // second derivatives, filled only when asked for
};

struct BodyShape {
    std::vector<LinkShape> link;
    double J, K;    // kg m^2
    double J1, K1;  // their derivatives by tau, filled with the second derivatives

    // Fill for one phase. `second` adds what accelerations need and friction does not.
    void set(const Robot& robot, const GaitTable& gait, double sin_tau, double cos_tau,
             bool second);

  private:
    void chain(double l, const GaitTable& gait, double sin_tau, double cos_tau);
    void centre();
    void rows();
};

inline void BodyShape::chain(double l, const GaitTable& gait, double sin_tau, double cos_tau) {
    const int n = gait.joints() + 1;
    link.resize(n);
    double angle = 0, s1 = 0, s2 = 0, c = 1, s = 0;
    double x = 0, y = 0, x1 = 0, y1 = 0, x2 = 0, y2 = 0;
    for (int i = 0;; ++i) {
        LinkShape& k = link[i];
        k.t.x = c, k.t.y = s, k.n.x = -s, k.n.y = c;
        k.rx = x, k.ry = y, k.rx1 = x1, k.ry1 = y1, k.rx2 = x2, k.ry2 = y2;
        k.s1 = s1, k.s2 = s2;
        if (i + 1 == n) return;
        // from this centre to the joint with the old angle, from the joint on with the new one
        x += l * c, y += l * s, x1 -= l * s1 * s, y1 += l * s1 * c;
        x2 -= l * (s2 * s + s1 * s1 * c), y2 += l * (s2 * c - s1 * s1 * s);
        const GaitTable::Joint j = gait.at(i, sin_tau, cos_tau);
        angle += j.angle, s1 += j.slope, s2 += j.curvature;
        c = std::cos(angle), s = std::sin(angle);
        x += l * c, y += l * s, x1 -= l * s1 * s, y1 += l * s1 * c;
        x2 -= l * (s2 * s + s1 * s1 * c), y2 += l * (s2 * c - s1 * s1 * s);
    }
}

inline void BodyShape::centre() {
    double x = 0, y = 0, x1 = 0, y1 = 0, x2 = 0, y2 = 0;
    for (const LinkShape& k : link)
        x += k.rx, y += k.ry, x1 += k.rx1, y1 += k.ry1, x2 += k.rx2, y2 += k.ry2;
    const double f = 1.0 / static_cast<double>(link.size());
    for (LinkShape& k : link) {
        k.rx -= f * x, k.ry -= f * y, k.rx1 -= f * x1, k.ry1 -= f * y1;
        k.rx2 -= f * x2, k.ry2 -= f * y2;
    }
}

inline void BodyShape::rows() {
    for (LinkShape& k : link) {
        k.t.r = k.rx * k.t.y - k.ry * k.t.x, k.t.e = k.t.x * k.rx1 + k.t.y * k.ry1;
        k.n.r = k.rx * k.n.y - k.ry * k.n.x, k.n.e = k.n.x * k.rx1 + k.n.y * k.ry1;
    }
}

inline void BodyShape::set(const Robot& robot, const GaitTable& gait, double sin_tau,
                           double cos_tau, bool second) {
    chain(robot.l, gait, sin_tau, cos_tau);
    centre();
    rows();
    double square = 0, cross = 0, turn = 0;
    for (const LinkShape& k : link) {
        square += k.rx * k.rx + k.ry * k.ry;
        cross += k.rx * k.ry1 - k.ry * k.rx1;
        turn += k.s1;
    }
    J = robot.n * robot.I + robot.m * square;
    K = robot.I * turn + robot.m * cross;
    if (!second) return;
    double dot = 0, cross2 = 0, turn2 = 0;
    for (const LinkShape& k : link) {
        dot += k.rx * k.rx1 + k.ry * k.ry1;
        cross2 += k.rx * k.ry2 - k.ry * k.rx2;
        turn2 += k.s2;
    }
    J1 = 2 * robot.m * dot;
    K1 = robot.I * turn2 + robot.m * cross2;
}

}  // namespace serpenoid
