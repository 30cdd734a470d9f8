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

#include "periodic/viscous/cycle_kernel.hpp"
#include "periodic/viscous/cycle_tables.hpp"

namespace serpenoid {
namespace {

class CyclePowers {
    static constexpr int kWide = kLocal;
    static constexpr int kBeyond = 4;  // nodes repeated before and after the half cycle

  public:
    explicit CyclePowers(const CycleTask& task)
        : q(task),
          N(task.nodes),
          motion(reinterpret_cast<Pack*>(task.work)),
          torque(motion + 10 * N + kBeyond),
          power(torque + N + 2 * kBeyond) {
        const CycleNewton gait(q);
        const Pack* y = reinterpret_cast<const Pack*>(q.y);
        const Pack g = *reinterpret_cast<const Pack*>(q.g);
        for (int k = 0; k < N; ++k) {
            Pack f[3];
            gait.slope(k, f);
            const Pack *u = y + 3 * k, nu = u[2];
            const Pack row[10] = {f[0] - nu * u[1], f[1] + nu * u[0], f[2],     nu * nu, nu,
                                  all(1),           g * u[0],         g * u[1], g * nu,  g};
            for (int b = 0; b < 10; ++b) motion[10 * k + b] = row[b];
        }
    }

    void run(Pack* out) {
        sum_ = Pack{}, error_ = Pack{};
        for (int i = 0; i < q.joints; ++i) joint(i);
        if (count_ > 0) flush();
        const Pack each = all(1.0 / N);
        out[kMeanAbsPower] = sum_ * each, out[kMeanAbsPowerError] = error_ * each;
    }

  private:
    // A pack of kinks where torques change sign; they may belong to different gaits and joints.
    struct Kinks {
        Pack torque[kWide], power[kWide];
        Pack sigma, place;  // in the cell; sigma 0: both are not known yet
        Pack turn;          // place at which the rate changes its sign, in the cell or outside
        Pack before;        // sign of the rate to the left of that
    };

    void joint(int i) {
        const double* table = q.joint + static_cast<long>(i) * kJointFields * N;
        const JointTurn& turn = q.turns[i];
        Pack high[4] = {}, sum{};
        for (int k = 0; k < N; ++k) {
            Pack T{};
            for (int b = 0; b < 10; ++b) T += all(table[b * N + k]) * motion[10 * k + b];
            T = choose(T == Pack{}, all(1e-300), T);  // a sign, opposite half a cycle later
            torque[k] = T, power[k] = T * all(table[kRate * N + k]);
            sum += choose(power[k] < 0, -power[k], power[k]);
            for (int c = 0; c < 4; ++c) high[c] += all(q.modes[8 * k + 4 + c]) * T;
        }
        sum_ += sum;
        // error by modes that the nodes do not resolve
        Pack tail{};
        for (const Pack& v : high) tail += v * v;
        error_ += square_root(tail * turn.swing) * all(kHidden / N);
        repeat();
        turns(turn);
        Pack begins = third_of_slope(0);
        PackBits above = torque[0] > 0;
        for (int k = 0; k < N; ++k) {
            const Pack ends = third_of_slope(k + 1);
            // A cubic has no more roots in the cell than its Bezier points, of the nodes' values
            // and slopes, have changes of sign.
            const PackBits inner = torque[k] + begins > 0, outer = torque[k + 1] - ends > 0;
            const PackBits next = torque[k + 1] > 0;
            const PackBits first = above ^ inner, second = inner ^ outer, last = outer ^ next;
            if (any(first | second | last)) cell(k, first, second, last, turn);
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
        Pack mend{}, at_place{}, sixth{}, seventh{};
        for (int j = 0; j < kWide; ++j) {
            const Pack own = power[k + j - 3];
            mend += all(turn.mend[j]) * own;
            sixth += all(q.stencil[kWide * 6 + j]) * own;
            seventh += all(q.stencil[kWide * 7 + j]) * own;
            at_place += all(turn.value[j]) * torque[k + j - 3];
        }
        sum_ += choose(at_place > 0, -mend, mend) * turn.before;
        error_ += doubt(sixth, seventh);
    }

    // Error of a correction, by the last coefficients of the power's polynomial.
    static Pack doubt(Pack sixth, Pack seventh) {
        const Pack a = choose(sixth < 0, -sixth, sixth), b = choose(seventh < 0, -seventh, seventh);
        return (a + b) * all(kLast);
    }

    // Roots of the torque in a cell; where Bezier points change their sign.
    void cell(int k, PackBits first, PackBits second, PackBits last, const JointTurn& turn) {
        const PackBits change = first ^ second ^ last;
        const PackBits several = (first & second) | (second & last) | (first & last);
        for (int lane = 0; lane < kPack; ++lane) {
            if (several[lane])
                search(k, lane, turn);
            else if (change[lane])
                push(k, lane, 0, 0, turn);
        }
    }

    // A third of the torque's slope at a node, per step: centred, of fourth order.
    Pack third_of_slope(int k) const {
        const Pack near = torque[k + 1] - torque[k - 1], far = torque[k + 2] - torque[k - 2];
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
        if (count_ == kPack) flush();
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
        Pack t[kWide] = {}, b[kWide] = {}, ends{};
        for (int p = 0; p < kWide; ++p)
            for (int j = 0; j < kWide; ++j) {
                const Pack m = all(q.stencil[kWide * p + j]);
                t[p] += m * kinks_.torque[j], b[p] += m * kinks_.power[j];
            }
        for (int j = 0; j < kWide; ++j) ends += all(q.stencil[kWide * kWide + j]) * kinks_.power[j];
        const PackBits given = (kinks_.sigma > 0) | (kinks_.sigma < 0);
        const Pack a = choose(given, kinks_.place, root(t));
        Pack reach{};
        for (int p = kWide - 1; p >= 0; --p) reach = reach * a + b[p] * all(1.0 / (p + 1));
        const Pack rate = choose(a < kinks_.turn, kinks_.before, -kinks_.before);
        const Pack after = kinks_.torque[4];  // at the cell's end
        const Pack sigma = choose(given, kinks_.sigma, choose(after > 0, rate, -rate));
        const Pack mend = 2 * sigma * (ends - a * reach), unsure = doubt(b[6], b[7]);
        for (int c = 0; c < count_; ++c) sum_[lane_[c]] += mend[c], error_[lane_[c]] += unsure[c];
        count_ = 0;
    }

    // Root in [0, 1] of a polynomial whose sign differs at the ends: bisection (another root may be
    // next to an end), then regula falsi, then Newton.
    Pack root(const Pack* t) const {
        Pack low{}, high = all(1), at_low = kinks_.torque[3], at_high = kinks_.torque[4], slope;
        for (int i = 0; i < 3; ++i) {
            const Pack x = 0.5 * (low + high), value = polynomial(t, x, slope);
            const PackBits left = (value > 0) ^ (at_low > 0);
            high = choose(left, x, high), at_high = choose(left, value, at_high);
            low = choose(left, low, x), at_low = choose(left, at_low, value);
        }
        Pack x = low + (high - low) * at_low / (at_low - at_high);
        for (int i = 0; i < 2; ++i) {
            const Pack value = polynomial(t, x, slope);
            x -= value / slope;
            x = choose(x > low, x, low);
            x = choose(x < high, x, high);
        }
        return x;
    }

    static Pack polynomial(const Pack* t, Pack x, Pack& slope) {
        Pack value = t[kWide - 1];
        slope = Pack{};
        for (int p = kWide - 2; p >= 0; --p) {
            slope = slope * x + value;
            value = value * x + t[p];
        }
        return value;
    }

    static constexpr double kHidden = 8;  // times the torque's last modes
    static constexpr double kLast =
        1.0 / 4;  // of the last coefficients, whose weights are 1/100 and less

    const CycleTask q;  // a copy: no store of packs can change it
    int N;
    Pack *motion, *torque, *power;
    Pack sum_, error_;
    Kinks kinks_{};
    int lane_[kPack];
    int count_ = 0;
};

void cycle_powers(CycleTask& q, double* out) { CyclePowers(q).run(reinterpret_cast<Pack*>(out)); }

}  // namespace
}  // namespace serpenoid
