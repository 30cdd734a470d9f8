// Mean of |P_i| over a cycle, by packs of gaits: sums over nodes, corrected where a power changes
// sign.
//
// q = T phi' repeats each half cycle and is smooth; s q, with the sign s that makes it positive,
// has kinks where s changes. For a kink at the place a of the cell [0, 1] between two nodes (phase
// in steps), s = sigma to its right, and q = sum b_j t^j about the cell's left node,
//     integral |q| = sum over nodes |q| + 2 sigma sum_j b_j (B_{j+1} - a^{j+1}) / (j + 1),
// with Bernoulli's numbers B_1 = 1/2, 1/6, 0, -1/30, ...: the end corrections of Euler and
// Maclaurin. b is a polynomial through eight nodes; that is accurate enough for a small correction.
#pragma once

#include "kernels/cycle_kernel.hpp"
#include "kernels/cycle_shape.hpp"

namespace serpenoid::kernels {
namespace {

template <int W>
class CyclePowers {
    using V = Pack<W>;
    using B = BitsOf<V>;
    static constexpr int kWide = kLocal;
    static constexpr int kBeyond = 4;  // nodes repeated before and after the half cycle

  public:
    explicit CyclePowers(const CycleTask& task)
        : q(task),
          N(task.nodes),
          motion(reinterpret_cast<V*>(task.work)),
          torque(motion + 10 * N + kBeyond),
          power(torque + N + 2 * kBeyond) {
        const CycleNewton<W> gait(q);
        const V* y = reinterpret_cast<const V*>(q.y);
        const V g = *reinterpret_cast<const V*>(q.g);
        for (int k = 0; k < N; ++k) {
            V f[3];
            gait.slope(k, f);
            const V *u = y + 3 * k, nu = u[2];
            const V row[10] = {f[0] - nu * u[1], f[1] + nu * u[0], f[2],     nu * nu, nu,
                               all<V>(1),        g * u[0],         g * u[1], g * nu,  g};
            for (int b = 0; b < 10; ++b) motion[10 * k + b] = row[b];
        }
    }

    void run(V* out) {
        sum_ = V{}, error_ = V{};
        for (int i = 0; i < q.joints; ++i) joint(i);
        if (count_ > 0) flush();
        const V each = all<V>(1.0 / N);
        out[kAbsPower] = sum_ * each, out[kAbsPowerError] = error_ * each;
    }

  private:
    // A pack of kinks where torques change sign; they may belong to different gaits and joints.
    struct Kinks {
        V torque[kWide], power[kWide];
        V sigma, place;  // in the cell; sigma 0: both are not known yet
        V turn;          // place at which the rate changes its sign, in the cell or outside
        V before;        // sign of the rate to the left of that
    };

    void joint(int i) {
        const double* table = q.joint + static_cast<long>(i) * kJointFields * N;
        const JointTurn& turn = q.turns[i];
        V high[4] = {}, sum{};
        for (int k = 0; k < N; ++k) {
            V T{};
            for (int b = 0; b < 10; ++b) T = fused(all<V>(table[b * N + k]), motion[10 * k + b], T);
            T = choose<V>(T == V{}, all<V>(1e-300), T);  // a sign, opposite half a cycle later
            torque[k] = T, power[k] = T * all<V>(table[kRate * N + k]);
            sum += choose<V>(power[k] < 0, -power[k], power[k]);
            for (int c = 0; c < 4; ++c) high[c] = fused(all<V>(q.modes[8 * k + 4 + c]), T, high[c]);
        }
        sum_ += sum;
        // error by modes that the nodes do not resolve
        V tail{};
        for (const V& v : high) tail += v * v;
        error_ += square_root(tail * turn.swing) * all<V>(kHidden / N);
        repeat();
        turns(turn);
        V begins = third_of_slope(0);
        B above = torque[0] > 0;
        for (int k = 0; k < N; ++k) {
            const V ends = third_of_slope(k + 1);
            // A cubic has no more roots in the cell than its Bezier points, of the nodes' values
            // and slopes, have changes of sign.
            const B inner = torque[k] + begins > 0, outer = torque[k + 1] - ends > 0;
            const B next = torque[k + 1] > 0;
            const B first = above ^ inner, second = inner ^ outer, last = outer ^ next;
            if (any<V>(first | second | last)) cell(k, first, second, last, turn);
            begins = ends, above = next;
        }
    }

    // The half cycle's neighbours: torque changes its sign from one to the next, power does not.
    void repeat() {
        for (int j = 0; j < kBeyond; ++j) {
            torque[N + j] = -torque[j], torque[-1 - j] = -torque[N - 1 - j];
            power[N + j] = power[j], power[-1 - j] = power[N - 1 - j];
        }
    }

    // The kink where the joint's rate changes its sign.
    void turns(const JointTurn& turn) {
        const int k = turn.place < N ? static_cast<int>(turn.place) : N - 1;
        V mend{}, at_place{}, sixth{}, seventh{};
        for (int j = 0; j < kWide; ++j) {
            const V own = power[k + j - 3];
            mend = fused(all<V>(turn.mend[j]), own, mend);
            sixth = fused(all<V>(q.stencil[kWide * 6 + j]), own, sixth);
            seventh = fused(all<V>(q.stencil[kWide * 7 + j]), own, seventh);
            at_place = fused(all<V>(turn.value[j]), torque[k + j - 3], at_place);
        }
        sum_ += choose<V>(at_place > 0, -mend, mend) * turn.before;
        error_ += doubt(sixth, seventh);
    }

    // Error of a correction, by the last coefficients of the power's polynomial.
    static V doubt(V sixth, V seventh) {
        const V a = choose<V>(sixth < 0, -sixth, sixth),
                b = choose<V>(seventh < 0, -seventh, seventh);
        return (a + b) * all<V>(kLast);
    }

    // Roots of the torque in a cell; where Bezier points change their sign.
    void cell(int k, B first, B second, B last, const JointTurn& turn) {
        const B change = first ^ second ^ last;
        const B several = (first & second) | (second & last) | (first & last);
        for (int lane = 0; lane < W; ++lane) {
            if (several[lane])
                search(k, lane, turn);
            else if (change[lane])
                push(k, lane, 0, 0, turn);
        }
    }

    // A third of the torque's slope at a node, per step: centred, of fourth order.
    V third_of_slope(int k) const {
        const V near = torque[k + 1] - torque[k - 1], far = torque[k + 2] - torque[k - 2];
        return near * (2.0 / 9) - far * (1.0 / 36);
    }

    void push(int k, int lane, double place, double sigma, const JointTurn& turn) {
        const int c = count_++;
        for (int j = 0; j < kWide; ++j) {
            kinks_.torque[j][c] = torque[k + j - 3][lane];
            kinks_.power[j][c] = power[k + j - 3][lane];
        }
        kinks_.place[c] = place, kinks_.sigma[c] = sigma;
        kinks_.turn[c] = turn.place - k, kinks_.before[c] = turn.before, lane_[c] = lane;
        if (count_ == W) flush();
    }

    // Find all roots in one cell, also a close pair, by the signs at sixteen places, denser near
    // the ends. At the ends the signs at the nodes count, as in the neighbouring cells.
    [[gnu::noinline]] void search(int k, int lane, const JointTurn& turn) {
        constexpr int kPlaces = 16;
        double b[kWide] = {};
        for (int j = 0; j < kWide; ++j)
            for (int p = 0; p < kWide; ++p)
                b[p] += q.stencil[kWide * p + j] * torque[k + j - 3][lane];
        const auto value = [&](double x) {
            double sum = b[kWide - 1];
            for (int p = kWide - 2; p >= 0; --p) sum = sum * x + b[p];
            return sum;
        };
        double old = torque[k][lane], before_x = 0;
        for (int i = 1; i <= kPlaces; ++i) {
            const double even = static_cast<double>(i) / kPlaces, x = even * even * (3 - 2 * even);
            const double now = i < kPlaces ? value(x) : torque[k + 1][lane];
            if ((old > 0) != (now > 0)) {
                double low = before_x, high = x;
                for (int half = 0; half < 20; ++half) {
                    const double middle = (low + high) / 2;
                    ((value(middle) > 0) == (old > 0) ? low : high) = middle;
                }
                const double rate = low < turn.place - k ? turn.before : -turn.before;
                push(k, lane, low, now > 0 ? rate : -rate, turn);
            }
            old = now, before_x = x;
        }
    }

    void flush() {
        V t[kWide] = {}, b[kWide] = {}, ends{};
        for (int p = 0; p < kWide; ++p)
            for (int j = 0; j < kWide; ++j) {
                const V m = all<V>(q.stencil[kWide * p + j]);
                t[p] = fused(m, kinks_.torque[j], t[p]), b[p] = fused(m, kinks_.power[j], b[p]);
            }
        for (int j = 0; j < kWide; ++j)
            ends = fused(all<V>(q.stencil[kWide * kWide + j]), kinks_.power[j], ends);
        const B given = (kinks_.sigma > 0) | (kinks_.sigma < 0);
        const V a = choose<V>(given, kinks_.place, root(t));
        V reach{};
        for (int p = kWide - 1; p >= 0; --p) reach = fused(reach, a, b[p] * all<V>(1.0 / (p + 1)));
        const V rate = choose<V>(a < kinks_.turn, kinks_.before, -kinks_.before);
        const V after = kinks_.torque[4];  // at the cell's end
        const V sigma = choose<V>(given, kinks_.sigma, choose<V>(after > 0, rate, -rate));
        const V mend = 2 * sigma * (ends - a * reach), unsure = doubt(b[6], b[7]);
        for (int c = 0; c < count_; ++c) sum_[lane_[c]] += mend[c], error_[lane_[c]] += unsure[c];
        count_ = 0;
    }

    // Root in [0, 1] of a polynomial whose sign differs at the ends: bisection (another root may be
    // next to an end), then regula falsi, then Newton.
    V root(const V* t) const {
        V low{}, high = all<V>(1), at_low = kinks_.torque[3], at_high = kinks_.torque[4], slope;
        for (int i = 0; i < 3; ++i) {
            const V x = 0.5 * (low + high), value = polynomial(t, x, slope);
            const B left = (value > 0) ^ (at_low > 0);
            high = choose<V>(left, x, high), at_high = choose<V>(left, value, at_high);
            low = choose<V>(left, low, x), at_low = choose<V>(left, at_low, value);
        }
        V x = low + (high - low) * at_low / (at_low - at_high);
        for (int i = 0; i < 2; ++i) {
            const V value = polynomial(t, x, slope);
            x -= value / slope;
            x = choose<V>(x > low, x, low);
            x = choose<V>(x < high, x, high);
        }
        return x;
    }

    static V polynomial(const V* t, V x, V& slope) {
        V value = t[kWide - 1];
        slope = V{};
        for (int p = kWide - 2; p >= 0; --p) {
            slope = fused(slope, x, value);
            value = fused(value, x, t[p]);
        }
        return value;
    }

    static constexpr double kHidden = 8;  // times the torque's last modes
    static constexpr double kLast =
        1.0 / 4;  // of the last coefficients, whose weights are 1/100 and less

    const CycleTask q;  // a copy: no store of packs can change it
    int N;
    V *motion, *torque, *power;
    V sum_, error_;
    Kinks kinks_{};
    int lane_[W];
    int count_ = 0;
};

template <int W>
void cycle_powers(CycleTask& q, double* out) {
    CyclePowers<W>(q).run(reinterpret_cast<Pack<W>*>(out));
}

template <int W>
constexpr CycleKernel cycle_kernel() {
    return {CycleTables<W>::run, cycle_slopes<W>, cycle_blend<W>, cycle_newton<W>,
            cycle_averages<W>,   cycle_powers<W>, cycle_refine<W>};
}

}  // namespace
}  // namespace serpenoid::kernels
