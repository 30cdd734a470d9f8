// Tables of a gait's shape on viscous ground, by packs of phases (spectral.hpp).
#pragma once

#include "body/body_shape.hpp"
#include "body/viscous_drag.hpp"
#include "periodic/viscous/cycle_table.hpp"

namespace serpenoid {
namespace {

struct CycleTables {
    const Robot& r;
    const Ground& ground;
    int nodes;

    void put(double* table, int field, int at, Pack value) const {
        pack_at(table + static_cast<long>(field) * nodes + at) = value;
    }

    void node(const BodyShapeOf<Pack>& shape, double* to, int at) const {
        const ViscousSumsOf<Pack> sum(shape, ground);
        const Pack im = all(1 / (r.n * r.m)), iJ = 1.0 / shape.J, spin = shape.K * iJ;
        const Pack *D = sum.D, *d = sum.d;
        put(to, kBxx, at, D[0] * im), put(to, kBxy, at, D[1] * im), put(to, kBxw, at, D[2] * im);
        put(to, kByy, at, D[3] * im), put(to, kByw, at, D[4] * im), put(to, kBx, at, d[0] * im);
        put(to, kBy, at, d[1] * im), put(to, kWx, at, D[2] * iJ), put(to, kWy, at, D[4] * iJ);
        put(to, kWw, at, D[5] * iJ), put(to, kW, at, d[2] * iJ), put(to, kJ1, at, shape.J1 * iJ);
        put(to, kK1, at, shape.K1 * iJ), put(to, kArm2, at, shape.J * im);
        put(to, kSpin2, at, spin * spin), put(to, kLoss, at, sum.dd * im);
    }

    // Joint forces and torques (joint_sums.hpp) of ten motions, each by itself.
    void joints(const BodyShapeOf<Pack>& shape, double* to, int at) const {
        const Pack m = all(r.m), none{};
        Pack Fx[10] = {}, Fy[10] = {}, T[10] = {};
        for (int i = 0; i + 1 < r.n; ++i) {
            const auto& k = shape.link[i];
            const auto &t = k.t, &n = k.n;
            const double ct = ground.ct, cn = ground.cn;
            const Pack px[10] = {m,
                                 none,
                                 -m * k.ry,
                                 -m * k.rx,
                                 -2 * m * k.ry1,
                                 m * k.rx2,
                                 ct * t.x * t.x + cn * n.x * n.x,
                                 ct * t.x * t.y + cn * n.x * n.y,
                                 ct * t.x * t.r + cn * n.x * n.r,
                                 ct * t.x * t.e + cn * n.x * n.e};
            const Pack py[10] = {none,
                                 m,
                                 m * k.rx,
                                 -m * k.ry,
                                 2 * m * k.rx1,
                                 m * k.ry2,
                                 px[7],
                                 ct * t.y * t.y + cn * n.y * n.y,
                                 ct * t.y * t.r + cn * n.y * n.r,
                                 ct * t.y * t.e + cn * n.y * n.e};
            T[kByTurning] += r.I, T[kByShape] += r.I * k.s2;
            double* row = to + static_cast<long>(i) * kJointFields * nodes;
            for (int b = 0; b < 10; ++b) {
                const Pack Gx = Fx[b] + px[b], Gy = Fy[b] + py[b];
                T[b] -= r.l * (t.x * (Fy[b] + Gy) - t.y * (Fx[b] + Gx));
                Fx[b] = Gx, Fy[b] = Gy;
                put(row, b, at, T[b]);
            }
            put(row, kRate, at, shape.link[i + 1].s1 - k.s1);
        }
    }
};

// Fill the tables at so many phases, a multiple of the pack; joint may be null.
inline void cycle_tables(const Robot& robot, const Ground& ground, const GaitTable& gait,
                         const double* sine, const double* cosine, int nodes, double* node,
                         double* joint) {
    const CycleTables tables{robot, ground, nodes};
    BodyShapeOf<Pack> shape;
    for (int at = 0; at < nodes; at += kPack) {
        shape.set(robot, gait, Pack{sine[at], sine[at + 1]}, Pack{cosine[at], cosine[at + 1]},
                  true);
        tables.node(shape, node, at);
        if (joint) tables.joints(shape, joint, at);
    }
}

// Derivatives of some fields at a pack of nodes by one row of their matrix.
template <int count>
inline void slopes_at(const int (&fields)[count], int N, const double* row, int at, double* node) {
    Pack sum[count] = {};
    for (int j = 0; j < N; ++j) {
        Pack weight;
        __builtin_memcpy(&weight, row - j, sizeof weight);
        for (int f = 0; f < count; ++f) sum[f] += weight * all(node[fields[f] * N + j]);
    }
    for (int f = 0; f < count; ++f)
        *reinterpret_cast<Pack*>(node + static_cast<long>(kSlope + fields[f]) * N + at) = sum[f];
}

void cycle_slopes(int N, const double* even, const double* odd, double* node) {
    constexpr int kEven[] = {kBxx, kByy, kByw, kWy, kWw, kJ1}, kOdd[] = {kBxy, kBxw, kWx};
    for (int at = 0; at < N; at += kPack) {
        slopes_at(kEven, N, even + at + N - 1, at, node);
        slopes_at(kOdd, N, odd + at + N - 1, at, node);
    }
}

}  // namespace
}  // namespace serpenoid
