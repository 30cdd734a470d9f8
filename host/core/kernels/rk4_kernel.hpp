// The implicit model with imposed angles under RK4, for packs of any width.
//
// theta_i = theta_1 + s_i(t) with s_i known beforehand: cos and sin of s_i are needed at two times
// a step only (the middle serves two stages, the end the next step's first), and a rotation by
// theta_1 makes those of theta_i. Positions are integrals of velocities, so with stage velocities
// v1..v4 and accelerations a1..a4 the classical method is
//     x2 = x + h/2 v,  x3 = x + h/2 v2,  x4 = x + h v3,  x' = x + h (v + h/6 (a1 + a2 + a3)),
//     v2 = v + h/2 a1, v3 = v + h/2 a2,  v4 = v + h a3,  v' = v + h/6 (a1 + 2 (a2 + a3) + a4).
// Unused lanes have no joint: on level ground they rest, on tilted ground each slides by itself.
#pragma once

#include "kernels/kernel_table.hpp"
#include "kernels/pack.hpp"

namespace serpenoid::kernels {
namespace {

// Lanes are links: the neighbour is a lane away.
template <class V>
V link_before(V previous, V current) {
    if constexpr (sizeof(V) == 32) return V{previous[3], current[0], current[1], current[2]};
    if constexpr (sizeof(V) == 16) return V{previous[1], current[0]};
    return previous;
}

template <class V>
V link_after(V current, V next) {
    if constexpr (sizeof(V) == 32) return V{current[1], current[2], current[3], next[0]};
    if constexpr (sizeof(V) == 16) return V{current[1], next[0]};
    return next;
}

template <class V>
struct PackedViscous {
    explicit PackedViscous(const Task& q) : ct(all<V>(-q.ground.ct)), cn(all<V>(-q.ground.cn)) {}
    V along(V v) const { return ct * v; }
    V across(V v) const { return cn * v; }
    V ct, cn;
};

// -(c v + F0 sgn v), sgn 0 = 0.
template <class V>
struct Dry : PackedViscous<V> {
    explicit Dry(const Task& q)
        : PackedViscous<V>(q), ft0(all<V>(-q.ground.ft0)), fn0(all<V>(-q.ground.fn0)) {}
    static V sgn(V v) { return choose<V>(v > 0, all<V>(1), choose<V>(v < 0, all<V>(-1), v)); }
    V along(V v) const { return fused(this->ct, v, ft0 * sgn(v)); }
    V across(V v) const { return fused(this->cn, v, fn0 * sgn(v)); }
    V ft0, fn0;
};

// sgn v replaced by v / sqrt(v^2 + width^2).
template <class V>
struct PackedSmoothed : Dry<V> {
    explicit PackedSmoothed(const Task& q) : Dry<V>(q), square(all<V>(q.smoothing * q.smoothing)) {}
    V soft(V v) const { return v / square_root(fused(v, v, square)); }
    V along(V v) const { return fused(this->ct, v, this->ft0 * soft(v)); }
    V across(V v) const { return fused(this->cn, v, this->fn0 * soft(v)); }
    V square;
};

// The same two with other coefficients backwards (friction_law.hpp).
template <class V>
struct PackedRatchet : Dry<V> {
    explicit PackedRatchet(const Task& q)
        : Dry<V>(q), ct_back(all<V>(-q.ground.ct_back)), ft0_back(all<V>(-q.ground.ft0_back)) {}
    V along(V v) const {
        const BitsOf<V> back = v < 0;
        return fused(choose<V>(back, ct_back, this->ct), v,
                     choose<V>(back, ft0_back, this->ft0) * Dry<V>::sgn(v));
    }
    V ct_back, ft0_back;
};

template <class V>
struct PackedSmoothedRatchet : PackedSmoothed<V> {
    explicit PackedSmoothedRatchet(const Task& q)
        : PackedSmoothed<V>(q),
          ct_half(all<V>(-0.5 * (q.ground.ct - q.ground.ct_back))),
          ft0_half(all<V>(-0.5 * (q.ground.ft0 - q.ground.ft0_back))) {
        this->ct = all<V>(-0.5 * (q.ground.ct + q.ground.ct_back));
        this->ft0 = all<V>(-0.5 * (q.ground.ft0 + q.ground.ft0_back));
    }
    V along(V v) const {
        const V s = this->soft(v);
        return fused(fused(ct_half, s, this->ct), v, fused(ft0_half, s, this->ft0) * s);
    }
    V ct_half, ft0_half;
};

template <int W, template <class> class LawOf, bool kTilted>
class Stepper {
    using V = Pack<W>;

  public:
    explicit Stepper(Task& task)
        : q(task),
          law(task),
          l(all<V>(task.robot.l)),
          per_mass(all<V>(1 / task.robot.m)),
          per_inertia(all<V>(1 / (task.robot.n * task.robot.I))),
          weight_x(all<V>(task.robot.m * task.slope.gx)),
          weight_y(all<V>(task.robot.m * task.slope.gy)),
          inertia(all<V>(task.robot.I)) {}

    void step(double t, double end) {
        const int from = q.shape, to = 2 - from;
        const double h = end - t;
        if (q.shape_s != t) shape(from, t);
        shape(1, t + h / 2);
        shape(to, end);
        stages(from, to, all<V>(h), all<V>(h / 2), all<V>(h / 6));
        q.shape = to, q.shape_s = end;
    }

  private:
    V& one(int which) const { return reinterpret_cast<V*>(q.memory)[which]; }
    V* begin() const { return reinterpret_cast<V*>(q.memory) + kOnes; }
    V* end() const { return begin() + static_cast<long>(q.rows) * kRow; }

    // cos and sin of theta_i - theta_1, its rate, and the sum of its second derivatives. Angles are
    // near: 2 pi a link at most, and links are fewer than kFar / (2 pi).
    void shape(int which, double t) {
        const V w = one(kGaitOmega);
        V sine, cosine;
        sincos(w * t, sine, cosine);
        one(kTurns + which) = -(w * w) * fused(one(kTurnSin), sine, one(kTurnCos) * cosine);
        for (V *k = begin(), *last = end(); k != last; k += kRow) {
            const V a = k[kAngleSin], b = k[kAngleCos];
            V* to = k + kShape + 3 * which;
            sincos_near(fused(a, sine, fused(b, cosine, k[kAngleOffset])), to[1], to[0]);
            to[2] = w * fused_less(a, cosine, b * sine);
        }
    }

    // On a row of links: l (cos, sin), friction and weight, force of the joint before each.
    struct Load {
        V arm_x, arm_y, ground_x, ground_y, force_x, force_y;
    };
    // Front ends of a row of links.
    struct Head {
        V x, y, vx, vy;
    };

    // `k` and `at` are the row and its stage's place in it; `head` goes from row to row.
    Load load(const V* k, const V* at, const V* shape, V ct, V st, V omega, Head& head) const {
        const V c = fused_less(ct, shape[0], st * shape[1]), s = fused(st, shape[0], ct * shape[1]);
        const V turn = omega + shape[2], x = at[0], y = at[1], vx = at[2], vy = at[3];
        const V arm_x = l * c, arm_y = l * s, wx = turn * arm_y, wy = turn * arm_x;
        const Head now{x + arm_x, y + arm_y, vx - wx, vy + wy};
        const V gap_x = x - arm_x - link_before(head.x, now.x);
        const V gap_y = y - arm_y - link_before(head.y, now.y);
        const V rate_x = vx + wx - link_before(head.vx, now.vx);
        const V rate_y = vy - wy - link_before(head.vy, now.vy);
        head = now;
        const V ft = law.along(fused(c, vx, s * vy)), fn = law.across(fused_less(c, vy, s * vx));
        V ground_x = fused_less(ft, c, fn * s), ground_y = fused(ft, s, fn * c);
        if constexpr (kTilted) ground_x = ground_x + weight_x, ground_y = ground_y + weight_y;
        return {arm_x,
                arm_y,
                ground_x,
                ground_y,
                fused(k[kStiffness], gap_x, k[kDamping] * rate_x),
                fused(k[kStiffness], gap_y, k[kDamping] * rate_y)};
    }

    // Hand every row and its accelerations to `use` and return that of theta_1. `at` is the place
    // of the stage in a row. A row is finished when the next one's force is known.
    template <class Use>
    V accelerations(int which, int at, V theta, V omega, const Use& use) {
        V st, ct, couple{};
        sincos(theta, st, ct);
        Head head{};
        Load load_before{};
        const auto finish = [&](V* k, const Load& on, V next_x, V next_y) {
            const V qx = link_after(on.force_x, next_x), qy = link_after(on.force_y, next_y);
            couple = couple + fused_less(on.arm_x, on.force_y + qy, on.arm_y * (on.force_x + qx));
            use(k, per_mass * (on.ground_x + (qx - on.force_x)),
                per_mass * (on.ground_y + (qy - on.force_y)));
        };
        V *k = begin(), *last = end();
        for (; k != last; k += kRow) {
            const Load now = load(k, k + at, k + kShape + 3 * which, ct, st, omega, head);
            if (k != begin()) finish(k - kRow, load_before, now.force_x, now.force_y);
            load_before = now;
        }
        finish(k - kRow, load_before, V{}, V{});
        return per_inertia * (total(couple) - inertia * one(kTurns + which));
    }

    // From the stage's velocities v_s and accelerations: the next stage's place and velocities.
    static void next_stage(V* k, V h, const V* v, V ax, V ay) {
        k[kStageX] = fused(h, v[0], k[kX]), k[kStageY] = fused(h, v[1], k[kY]);
        k[kStageVx] = fused(h, ax, k[kVx]), k[kStageVy] = fused(h, ay, k[kVy]);
    }

    void stages(int from, int to, V h, V half, V sixth) {
        const V theta = one(kTheta), omega = one(kOmega);
        const V a1 = accelerations(from, kX, theta, omega, [=](V* k, const V& ax, const V& ay) {
            k[kFirstX] = ax, k[kFirstY] = ay;
            next_stage(k, half, k + kVx, ax, ay);
        });
        const V theta2 = fused(half, omega, theta), omega2 = fused(half, a1, omega);
        const V a2 = accelerations(1, kStageX, theta2, omega2, [=](V* k, const V& ax, const V& ay) {
            k[kRestX] = ax, k[kRestY] = ay;
            next_stage(k, half, k + kStageVx, ax, ay);
        });
        const V theta3 = fused(half, omega2, theta), omega3 = fused(half, a2, omega);
        const V a3 = accelerations(1, kStageX, theta3, omega3, [=](V* k, const V& ax, const V& ay) {
            k[kRestX] = k[kRestX] + ax, k[kRestY] = k[kRestY] + ay;
            next_stage(k, h, k + kStageVx, ax, ay);
            k[kX] = fused(h, fused(sixth, k[kFirstX] + k[kRestX], k[kVx]), k[kX]);
            k[kY] = fused(h, fused(sixth, k[kFirstY] + k[kRestY], k[kVy]), k[kY]);
        });
        const V theta4 = fused(h, omega3, theta), omega4 = fused(h, a3, omega);
        const V a4 =
            accelerations(to, kStageX, theta4, omega4, [=](V* k, const V& ax, const V& ay) {
                k[kVx] = fused(sixth, k[kFirstX] + 2 * k[kRestX] + ax, k[kVx]);
                k[kVy] = fused(sixth, k[kFirstY] + 2 * k[kRestY] + ay, k[kVy]);
            });
        one(kTheta) = fused(h, fused(sixth, a1 + (a2 + a3), omega), theta);
        one(kOmega) = fused(sixth, a1 + 2 * (a2 + a3) + a4, omega);
    }

    Task& q;
    LawOf<V> law;
    V l, per_mass, per_inertia, weight_x, weight_y, inertia;
};

template <int W, template <class> class LawOf, bool kTilted>
void rk4_step(Task& q, double t, double end) {
    Stepper<W, LawOf, kTilted>(q).step(t, end);
}

template <int W, bool kTilted>
constexpr Steps steps_of() {
    return {rk4_step<W, PackedViscous, kTilted>, rk4_step<W, Dry, kTilted>,
            rk4_step<W, PackedSmoothed, kTilted>, rk4_step<W, PackedRatchet, kTilted>,
            rk4_step<W, PackedSmoothedRatchet, kTilted>};
}

template <int W>
void sincos_packs(const double* x, double* sine, double* cosine, long packs) {
    using V = Pack<W>;
    for (long i = 0; i < packs; ++i)
        sincos(reinterpret_cast<const V*>(x)[i], reinterpret_cast<V*>(sine)[i],
               reinterpret_cast<V*>(cosine)[i]);
}

template <int W>
constexpr Set set_of(const char* name, CycleKernel cycle, StageKernel stage) {
    return {name, W, {steps_of<W, false>(), steps_of<W, true>()}, sincos_packs<W>, cycle, stage};
}

}  // namespace
}  // namespace serpenoid::kernels
