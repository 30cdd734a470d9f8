// Tables of a gait's shape on viscous ground, by packs of phases (periodic/spectral.hpp).
#pragma once

#include "kernels/cycle_table.hpp"
#include "kernels/pack.hpp"

namespace serpenoid::kernels {
namespace {

// Links of a shape at a pack of phases; body_shape.hpp has the formulas. Without `second` the
// second derivatives stay empty.
template <class V, bool second = true>
struct ShapeOfPhases {
    struct Link {
        V c, s, rx, ry, rx1, ry1, rx2, ry2, s1, s2;
    };
    Link* link;
    int n;
    V J, K, J1, K1;

    ShapeOfPhases(const CycleChain& q, V sine, V cosine, double* scratch)
        : link(reinterpret_cast<Link*>(scratch)), n(q.links) {
        place(q, sine, cosine);
        centre();
        moments(q);
    }

  private:
    void place(const CycleChain& q, V sine, V cosine) {
        const V l = all<V>(q.half_length);
        V angle{}, s1{}, s2{}, c = all<V>(1), s{}, x{}, y{}, x1{}, y1{}, x2{}, y2{};
        const auto half = [&] {
            x += l * c, y += l * s, x1 -= l * s1 * s, y1 += l * s1 * c;
            if constexpr (second)
                x2 -= l * (s2 * s + s1 * s1 * c), y2 += l * (s2 * c - s1 * s1 * s);
        };
        for (int i = 0;; ++i) {
            link[i] = {c, s, x, y, x1, y1, x2, y2, s1, s2};
            if (i + 1 == n) return;
            half();
            const V a = all<V>(q.cosine[i]), b = all<V>(q.sine[i]);
            const V swing = a * sine + b * cosine;
            angle += all<V>(q.offset) + swing, s1 += a * cosine - b * sine, s2 -= swing;
            sincos(angle, s, c);
            half();
        }
    }

    void centre() {
        constexpr int kFields = second ? 6 : 4;
        V sum[kFields] = {};
        for (int i = 0; i < n; ++i)
            for (int k = 0; k < kFields; ++k) sum[k] += (&link[i].rx)[k];
        for (V& v : sum) v *= all<V>(1.0 / n);
        for (int i = 0; i < n; ++i)
            for (int k = 0; k < kFields; ++k) (&link[i].rx)[k] -= sum[k];
    }

    void moments(const CycleChain& q) {
        V square{}, cross{}, turn{}, dot{}, cross2{}, turn2{};
        for (int i = 0; i < n; ++i) {
            const Link& k = link[i];
            square += k.rx * k.rx + k.ry * k.ry;
            cross += k.rx * k.ry1 - k.ry * k.rx1, turn += k.s1;
            if constexpr (!second) continue;
            dot += k.rx * k.rx1 + k.ry * k.ry1;
            cross2 += k.rx * k.ry2 - k.ry * k.rx2, turn2 += k.s2;
        }
        const V m = all<V>(q.mass), I = all<V>(q.inertia);
        J = static_cast<double>(n) * I + m * square, K = I * turn + m * cross;
        J1 = 2 * m * dot, K1 = I * turn2 + m * cross2;
    }
};

// Wheels of a link: speed along it t.(v) + tr nu + te, times omega, and likewise across it.
template <class V>
struct Wheels {
    V tr, te, nr, ne;
    template <class Link>
    explicit Wheels(const Link& k)
        : tr(k.rx * k.s - k.ry * k.c),
          te(k.c * k.rx1 + k.s * k.ry1),
          nr(k.rx * k.c + k.ry * k.s),
          ne(k.c * k.ry1 - k.s * k.rx1) {}
};

template <int W>
struct CycleTables {
    using V = Pack<W>;
    const CycleChain& q;
    int nodes;

    void put(double* table, int field, int at, V value) const {
        *reinterpret_cast<V*>(table + static_cast<long>(field) * nodes + at) = value;
    }

    void node(const ShapeOfPhases<V>& shape, double* to, int at) const {
        const V ct = all<V>(q.ct), cn = all<V>(q.cn);
        V xx{}, xy{}, xw{}, yy{}, yw{}, ww{}, x{}, y{}, w{}, loss{};
        for (int i = 0; i < q.links; ++i) {
            const auto& k = shape.link[i];
            const Wheels<V> f(k);
            xx += ct * k.c * k.c + cn * k.s * k.s, xy += (ct - cn) * k.c * k.s;
            yy += ct * k.s * k.s + cn * k.c * k.c;
            xw += ct * k.c * f.tr - cn * k.s * f.nr, yw += ct * k.s * f.tr + cn * k.c * f.nr;
            x += ct * k.c * f.te - cn * k.s * f.ne, y += ct * k.s * f.te + cn * k.c * f.ne;
            ww += ct * f.tr * f.tr + cn * f.nr * f.nr, w += ct * f.tr * f.te + cn * f.nr * f.ne;
            loss += ct * f.te * f.te + cn * f.ne * f.ne;
        }
        const V im = all<V>(1 / (q.links * q.mass)), iJ = 1.0 / shape.J;
        const V spin = shape.K * iJ;
        put(to, kBxx, at, xx * im), put(to, kBxy, at, xy * im), put(to, kBxw, at, xw * im);
        put(to, kByy, at, yy * im), put(to, kByw, at, yw * im), put(to, kBx, at, x * im);
        put(to, kBy, at, y * im), put(to, kWx, at, xw * iJ), put(to, kWy, at, yw * iJ);
        put(to, kWw, at, ww * iJ), put(to, kW, at, w * iJ), put(to, kJ1, at, shape.J1 * iJ);
        put(to, kK1, at, shape.K1 * iJ), put(to, kArm2, at, shape.J * im);
        put(to, kSpin2, at, spin * spin), put(to, kLoss, at, loss * im);
    }

    // Joint forces and torques (joint_sums.hpp) of ten motions, each by itself.
    void joints(const ShapeOfPhases<V>& shape, double* to, int at) const {
        const V m = all<V>(q.mass), I = all<V>(q.inertia), l = all<V>(q.half_length),
                ct = all<V>(q.ct), cn = all<V>(q.cn), none{};
        V Fx[10] = {}, Fy[10] = {}, T[10] = {};
        for (int i = 0; i + 1 < q.links; ++i) {
            const auto& k = shape.link[i];
            const Wheels<V> f(k);
            const V xy = (ct - cn) * k.c * k.s;
            const V px[10] = {m,
                              none,
                              -m * k.ry,
                              -m * k.rx,
                              -2 * m * k.ry1,
                              m * k.rx2,
                              ct * k.c * k.c + cn * k.s * k.s,
                              xy,
                              ct * k.c * f.tr - cn * k.s * f.nr,
                              ct * k.c * f.te - cn * k.s * f.ne};
            const V py[10] = {none,
                              m,
                              m * k.rx,
                              -m * k.ry,
                              2 * m * k.rx1,
                              m * k.ry2,
                              xy,
                              ct * k.s * k.s + cn * k.c * k.c,
                              ct * k.s * f.tr + cn * k.c * f.nr,
                              ct * k.s * f.te + cn * k.c * f.ne};
            T[kByTurning] += I, T[kByShape] += I * k.s2;
            double* row = to + static_cast<long>(i) * kJointFields * nodes;
            for (int b = 0; b < 10; ++b) {
                const V Gx = Fx[b] + px[b], Gy = Fy[b] + py[b];
                T[b] -= l * (k.c * (Fy[b] + Gy) - k.s * (Fx[b] + Gx));
                Fx[b] = Gx, Fy[b] = Gy;
                put(row, b, at, T[b]);
            }
            put(row, kRate, at, shape.link[i + 1].s1 - k.s1);
        }
    }

    static void run(const CycleChain& q, const double* sine, const double* cosine, int nodes,
                    double* node, double* joint, double* scratch) {
        const CycleTables tables{q, nodes};
        for (int at = 0; at < nodes; at += W) {
            V s, c;
            for (int j = 0; j < W; ++j) s[j] = sine[at + j], c[j] = cosine[at + j];
            const ShapeOfPhases<V> shape(q, s, c, scratch);
            tables.node(shape, node, at);
            if (joint) tables.joints(shape, joint, at);
        }
    }
};

// Derivatives of some fields at a pack of nodes by one row of their matrix.
template <int W, int count>
inline void slopes_at(const int (&fields)[count], int N, const double* row, int at, double* node) {
    using V = Pack<W>;
    V sum[count] = {};
    for (int j = 0; j < N; ++j) {
        V weight;
        __builtin_memcpy(&weight, row - j, sizeof weight);
        for (int f = 0; f < count; ++f)
            sum[f] = fused(weight, all<V>(node[fields[f] * N + j]), sum[f]);
    }
    for (int f = 0; f < count; ++f)
        *reinterpret_cast<V*>(node + static_cast<long>(kSlope + fields[f]) * N + at) = sum[f];
}

template <int W>
void cycle_slopes(int N, const double* even, const double* odd, double* node) {
    constexpr int kEven[] = {kBxx, kByy, kByw, kWy, kWw, kJ1}, kOdd[] = {kBxy, kBxw, kWx};
    for (int at = 0; at < N; at += W) {
        slopes_at<W>(kEven, N, even + at + N - 1, at, node);
        slopes_at<W>(kOdd, N, odd + at + N - 1, at, node);
    }
}

}  // namespace
}  // namespace serpenoid::kernels
