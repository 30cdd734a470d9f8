// The shape of the chain at up to eight phases side by side, by packs of them (stage_table.hpp).
#pragma once

#include "kernels/cycle_shape.hpp"
#include "kernels/stage_solve.hpp"
#include "kernels/stage_table.hpp"

namespace serpenoid::kernels {
namespace {

template <int W>
class StageShape {
    using V = Pack<W>;

    static V& in(Lanes& a, int p) { return *reinterpret_cast<V*>(a.at + p); }
    static const V& in(const Lanes& a, int p) { return *reinterpret_cast<const V*>(a.at + p); }

  public:
    static void shape(const CycleChain& q, int lanes, const Lanes& tau, StageSums& to,
                      StageWheel* wheel, double* scratch) {
        for (int p = 0; p < lanes; p += W) {
            V sine, cosine;
            sincos(in(tau, p), sine, cosine);
            const ShapeOfPhases<V, false> shape(q, sine, cosine, scratch);
            in(to.J, p) = shape.J, in(to.K, p) = shape.K;
            for (int i = 0; i < q.links; ++i) {
                const auto& k = shape.link[i];
                const Wheels<V> f(k);
                StageWheel &t = wheel[2 * i], &n = wheel[2 * i + 1];
                in(t.x, p) = k.c, in(t.y, p) = k.s, in(t.r, p) = f.tr, in(t.e, p) = f.te;
                in(n.x, p) = -k.s, in(n.y, p) = k.c, in(n.r, p) = f.nr, in(n.e, p) = f.ne;
            }
        }
    }

    static void sums(int wheels, int lanes, const StageWheel* wheel, const double* viscous,
                     const double* dry, StageSums& to) {
        for (int p = 0; p < lanes; p += W) {
            V D[6] = {}, d[3] = {}, dd{}, f[3] = {}, fe{};
            for (int i = 0; i < wheels; ++i) {
                const V x = in(wheel[i].x, p), y = in(wheel[i].y, p), r = in(wheel[i].r, p),
                        e = in(wheel[i].e, p), c = all<V>(viscous[i]), mu = all<V>(dry[i]);
                const V cx = c * x, cy = c * y, cr = c * r, ce = c * e;
                D[0] = fused(cx, x, D[0]), D[1] = fused(cx, y, D[1]), D[2] = fused(cx, r, D[2]);
                D[3] = fused(cy, y, D[3]), D[4] = fused(cy, r, D[4]), D[5] = fused(cr, r, D[5]);
                d[0] = fused(ce, x, d[0]), d[1] = fused(ce, y, d[1]), d[2] = fused(ce, r, d[2]);
                dd = fused(ce, e, dd);
                f[0] = fused(mu, x, f[0]), f[1] = fused(mu, y, f[1]), f[2] = fused(mu, r, f[2]);
                fe = fused(mu, e, fe);
            }
            for (int k = 0; k < 6; ++k) in(to.D[k], p) = D[k];
            for (int k = 0; k < 3; ++k) in(to.d[k], p) = d[k], in(to.dry[k], p) = f[k];
            in(to.dd, p) = dd, in(to.dry_e, p) = fe;
        }
    }

    static void speeds(int wheels, int lanes, const StageWheel* wheel, const Lanes* u, double omega,
                       Lanes* out) {
        for (int p = 0; p < lanes; p += W) {
            const V x = in(u[0], p), y = in(u[1], p), w = in(u[2], p), rate = all<V>(omega);
            for (int i = 0; i < wheels; ++i) {
                const StageWheel& g = wheel[i];
                V v = in(g.x, p) * x;
                v = fused(in(g.y, p), y, v), v = fused(in(g.r, p), w, v);
                in(out[i], p) = fused(in(g.e, p), rate, v);
            }
        }
    }

    static void lowest(int wheels, int points, const Lanes* weights, const Lanes* values,
                       double* out) {
        for (int i = 0; i < wheels; ++i) {
            const double* value = values[i].at;
            V least = all<V>(__builtin_inf());
            for (int p = 0; p < Lanes::kCount; p += W) {
                V sum{};
                for (int j = 0; j < points; ++j)
                    sum = fused(in(weights[j], p), all<V>(value[j]), sum);
                least = choose<V>(sum < least, sum, least);
            }
            double low = least[0];
            for (int j = 1; j < W; ++j) low = least[j] < low ? least[j] : low;
            out[i] = low;
        }
    }

    // joint_power.hpp has the formulas.
    static void torques(const CycleChain& q, int lanes, const Lanes& tau, const Lanes* momenta,
                        double omega, const double* viscous, const Lanes* dry, Lanes* torque,
                        Lanes* rate, double* scratch) {
        V* const friction = reinterpret_cast<V*>(scratch) + 10 * q.links;
        for (int p = 0; p < lanes; p += W) {
            V sine, cosine;
            sincos(in(tau, p), sine, cosine);
            const ShapeOfPhases<V> s(q, sine, cosine, scratch);
            const V o = all<V>(omega), im = all<V>(1 / (q.links * q.mass)),
                    x = in(momenta[0], p) * im, y = in(momenta[1], p) * im,
                    w = (in(momenta[2], p) - o * s.K) / s.J;
            V force[3] = {};
            for (int i = 0; i < q.links; ++i) {
                const auto& k = s.link[i];
                const Wheels<V> f(k);
                const V vt = k.c * x + k.s * y + f.tr * w + o * f.te,
                        vn = k.c * y - k.s * x + f.nr * w + o * f.ne,
                        ft = -in(dry[2 * i], p) - all<V>(viscous[2 * i]) * vt,
                        fn = -in(dry[2 * i + 1], p) - all<V>(viscous[2 * i + 1]) * vn;
                friction[2 * i] = ft * k.c - fn * k.s, friction[2 * i + 1] = ft * k.s + fn * k.c;
                force[0] += friction[2 * i], force[1] += friction[2 * i + 1];
                force[2] += ft * f.tr + fn * f.nr;
            }
            recover(q, p, s, force, w, o, friction, torque, rate);
        }
    }

    static constexpr StageKernel kernel() {
        return {shape, sums, speeds, lowest, torques, StageSolve<W>::run};
    }

  private:
    // The joints' torques link by link from the tail, as in joint_sums.hpp.
    static void recover(const CycleChain& q, int p, const ShapeOfPhases<V>& s, const V* force, V w,
                        V o, const V* friction, Lanes* torque, Lanes* rate) {
        const V m = all<V>(q.mass), I = all<V>(q.inertia), l = all<V>(q.half_length),
                im = all<V>(1 / (q.links * q.mass)), Ax = force[0] * im, Ay = force[1] * im,
                oo = o * o, ww = w * w, cross = 2 * w * o,
                turn = (force[2] - oo * s.K1 - o * s.J1 * w) / s.J;
        V Fx{}, Fy{}, T{};
        for (int i = 0; i + 1 < q.links; ++i) {
            const auto& k = s.link[i];
            const V ax = Ax - turn * k.ry - ww * k.rx - cross * k.ry1 + oo * k.rx2;
            const V ay = Ay + turn * k.rx - ww * k.ry + cross * k.rx1 + oo * k.ry2;
            const V Gx = Fx + m * ax - friction[2 * i], Gy = Fy + m * ay - friction[2 * i + 1];
            T += I * (turn + oo * k.s2) - l * (k.c * (Fy + Gy) - k.s * (Fx + Gx));
            Fx = Gx, Fy = Gy;
            in(torque[i], p) = T, in(rate[i], p) = o * (s.link[i + 1].s1 - k.s1);
        }
    }
};

}  // namespace
}  // namespace serpenoid::kernels
