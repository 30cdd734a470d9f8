// Periodic states on viscous ground by packs: Newton's steps, averages.
//
// The derivation stands in periodic/spectral.hpp.
#pragma once

#include "kernels/cycle_table.hpp"
#include "kernels/pack.hpp"

namespace serpenoid::kernels {
namespace {

template <class V>
struct Mat {
    V m[9];
    V& operator[](int i) { return m[i]; }
    const V& operator[](int i) const { return m[i]; }
};

template <class V>
inline Mat<V> product3(const Mat<V>& a, const Mat<V>& b) {
    Mat<V> c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            c[3 * i + j] =
                fused(a[3 * i + 2], b[6 + j], fused(a[3 * i + 1], b[3 + j], a[3 * i] * b[j]));
    return c;
}

// a b + c
template <class V>
inline Mat<V> product3(const Mat<V>& a, const Mat<V>& b, Mat<V> c) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                c[3 * i + j] = fused(a[3 * i + k], b[3 * k + j], c[3 * i + j]);
    return c;
}

template <class V>
inline void product3(const Mat<V>& a, const V* x, V* to) {
    for (int i = 0; i < 3; ++i)
        to[i] = fused(a[3 * i + 2], x[2], fused(a[3 * i + 1], x[1], a[3 * i] * x[0]));
}

template <class V>
inline Mat<V> inverse3(const Mat<V>& a) {
    const V c0 = fused_less(a[4], a[8], a[5] * a[7]), c1 = fused_less(a[5], a[6], a[3] * a[8]),
            c2 = fused_less(a[3], a[7], a[4] * a[6]);
    const V f = 1.0 / fused(a[0], c0, fused(a[1], c1, a[2] * c2));
    return {
        {f * c0, f * fused_less(a[2], a[7], a[1] * a[8]), f * fused_less(a[1], a[5], a[2] * a[4]),
         f * c1, f * fused_less(a[0], a[8], a[2] * a[6]), f * fused_less(a[2], a[3], a[0] * a[5]),
         f * c2, f * fused_less(a[1], a[6], a[0] * a[7]), f * fused_less(a[0], a[4], a[1] * a[3])}};
}

// Half a cycle later a matrix is its mirror image: entries between x and the other two change sign.
template <class V>
inline Mat<V> mirrored(Mat<V> a) {
    a[1] = -a[1], a[2] = -a[2], a[3] = -a[3], a[6] = -a[6];
    return a;
}

template <int W>
class CycleNewton {
    using V = Pack<W>;

  public:
    explicit CycleNewton(const CycleTask& task)
        : q(task),
          N(task.nodes),
          y(reinterpret_cast<V*>(task.y)),
          g(*reinterpret_cast<const V*>(task.g)),
          f(reinterpret_cast<V*>(task.work)),
          r(f + 3 * N),
          miss(r + 3 * N),
          cell(reinterpret_cast<Cell*>(miss + 3 * N)) {}

    void step(V* out) {
        for (int k = 0; k < N; ++k) slope(k, f + 3 * k);
        residuals();
        for (int k = 0; k < N; ++k) linearise(k);
        V start[3];
        chain(out + kTransfer, start);
        move(start, out);
    }

    // f = dy/dtau at a node.
    void slope(int k, V* to) const {
        const V *u = y + 3 * k, x = u[0], z = u[1], nu = u[2];
        const auto sum = [&](int a, int b, int c, int d) {
            return fused(at(a, k), x, fused(at(b, k), z, fused(at(c, k), nu, at(d, k))));
        };
        to[0] = fused_less(nu, z, g * sum(kBxx, kBxy, kBxw, kBx));
        to[1] = -fused(nu, x, g * sum(kBxy, kByy, kByw, kBy));
        to[2] = -fused(g, sum(kWx, kWy, kWw, kW), fused(at(kJ1, k), nu, at(kK1, k)));
    }

    V at(int field, int k) const { return all<V>(q.node[field * N + k]); }

  private:
    // The matrices of Hermite's rule at a node, then of the cell that begins there.
    struct Cell {
        Mat<V> half, plus, inverse;
        V correction[3];
    };

    // A = df/dy there, with `fields` the table of the matrix or of its derivative.
    Mat<V> matrix(int k, int fields, V x, V z, V nu) const {
        const V less = -g;
        const auto b = [&](int i) { return less * at(fields + i, k); };
        const auto with = [&](int i, V c) { return fused(less, at(fields + i, k), c); };
        return {{b(kBxx), with(kBxy, nu), with(kBxw, z), with(kBxy, -nu), b(kByy), with(kByw, -x),
                 b(kWx), b(kWy), with(kWw, -at(fields + kJ1, k))}};
    }

    void linearise(int k) {
        const V *u = y + 3 * k, *du = f + 3 * k;
        const Mat<V> A = matrix(k, 0, u[0], u[1], u[2]);
        const Mat<V> AA = product3(A, A, matrix(k, kSlope, du[0], du[1], du[2]));
        const V h2 = all<V>(q.step / 2), h12 = all<V>(q.step * q.step / 12);
        Mat<V> minus;
        for (int i = 0; i < 9; ++i) {
            const V B = i % 4 ? h12 * AA[i] : fused(h12, AA[i], all<V>(1));
            const V H = h2 * A[i];
            cell[k].half[i] = H, cell[k].plus[i] = B + H, minus[i] = B - H;
        }
        cell[k].inverse = inverse3(minus);
    }

    // Sums and differences of a pair (spectral_row.hpp), by component.
    struct Pair {
        V u[2][3], f[2][3];
    };

    // The pairs use the memory of the cells, which are filled later.
    Pair* fold() const {
        Pair* pair = reinterpret_cast<Pair*>(cell);
        for (int j = 0; j <= N / 2; ++j)
            for (int c = 0; c < 3; ++c) {
                const V u = y[3 * j + c], du = f[3 * j + c];
                const V mirror = y[3 * (N - 1 - j) + c];
                pair[j].u[0][c] = u + mirror, pair[j].u[1][c] = u - mirror;
                const bool alone = j == 0 || j == N / 2;
                const V other = alone ? V{} : f[3 * (N - j) + c];
                pair[j].f[0][c] = du + other, pair[j].f[1][c] = du - other;
            }
        return pair;
    }

    // r = f - y' at the nodes; miss: the integral of f over each cell less the change of y.
    void residuals() {
        const Pair* pairs = fold();
        for (int k = 0; k < N / 2; ++k) {
            V d[2][3] = {}, s[2][3] = {};
            for (int j = 0; j <= N / 2; ++j) {
                const FoldedRow& row = q.folded[k * (N / 2 + 1) + j];
                for (int i = 0; i < 2; ++i)
                    for (int c = 0; c < 3; ++c) {
                        const V slope = all<V>(c ? row.odd_slope[i] : row.even_slope[i]);
                        const V part = all<V>(c ? row.odd_integral[i] : row.even_integral[i]);
                        d[i][c] = fused(slope, pairs[j].u[i][c], d[i][c]);
                        s[i][c] = fused(part, pairs[j].f[i][c], s[i][c]);
                    }
            }
            for (int c = 0; c < 3; ++c) {
                residual(k, c, d[1][c] + d[0][c], s[0][c] + s[1][c]);
                residual(N - 1 - k, c, d[1][c] - d[0][c], s[0][c] - s[1][c]);
            }
        }
    }

    void residual(int k, int c, V slope, V integral) {
        const int a = 3 * k + c;
        const V next = k + 1 < N ? y[a + 3] : c ? -y[c] : y[c];
        r[a] = f[a] - slope, miss[a] = integral - (next - y[a]);
    }

    // Changes of all nodes as functions of the first one's: transfer matrices and their product.
    // The symmetry of the cycle gives the first one.
    void chain(V* transfer, V* start) {
        Mat<V> P = {{all<V>(1), V{}, V{}, V{}, all<V>(1), V{}, V{}, V{}, all<V>(1)}};
        V p[3] = {}, begin[3], from[3];
        product3(cell[0].half, r, begin);
        for (int c = 0; c < 3; ++c) from[c] = begin[c];
        for (int k = 0; k < N; ++k) {
            const bool last = k + 1 == N;
            const Cell& next = cell[last ? 0 : k + 1];
            V to[3] = {begin[0], -begin[1], -begin[2]}, right[3];
            if (!last) product3(next.half, r + 3 * (k + 1), to);
            const V h6 = all<V>(q.step / 6);
            for (int c = 0; c < 3; ++c) {
                right[c] = fused(h6, from[c] - to[c], miss[3 * k + c]);
                from[c] = to[c];
            }
            const Mat<V> inverse = last ? mirrored(first_) : next.inverse;
            if (k == 0) first_ = cell[0].inverse;
            product3(inverse, right, cell[k].correction);
            cell[k].inverse = product3(inverse, cell[k].plus);  // from now on the transfer matrix
            P = product3(cell[k].inverse, P);
            V q3[3];
            product3(cell[k].inverse, p, q3);
            for (int c = 0; c < 3; ++c) p[c] = q3[c] + cell[k].correction[c];
        }
        Mat<V> C;
        for (int i = 0; i < 9; ++i) {
            transfer[i] = i < 3 ? P[i] : -P[i];
            C[i] = (i % 4 ? 0.0 : i ? -1.0 : 1.0) - P[i];
        }
        product3(inverse3(C), p, start);
    }

    void move(V* d, V* out) {
        V change{}, size{};
        for (int k = 0; k < N; ++k) {
            V* u = y + 3 * k;
            for (int c = 0; c < 3; ++c) u[c] += d[c];
            const V arm = at(kArm2, k);
            change += d[0] * d[0] + d[1] * d[1] + arm * d[2] * d[2];
            size += u[0] * u[0] + u[1] * u[1] + arm * (u[2] * u[2] + at(kSpin2, k));
            V next[3];
            product3(cell[k].inverse, d, next);
            for (int c = 0; c < 3; ++c) d[c] = next[c] + cell[k].correction[c];
        }
        out[kChange2] = change, out[kSize2] = size;
    }

    const CycleTask q;  // a copy: no store of packs can change it
    int N;
    V* y;
    V g;
    V *f, *r, *miss;
    Cell* cell;
    Mat<V> first_;
};

// Binary logarithm of the largest eigenvalue's size: of ||M^k||^(1/k) for k = 4^13. Scaling is by
// powers of two, read from and put into the exponent's bits.
template <class V>
inline V log2_radius(Mat<V> M) {
    using B = BitsOf<V>;
    V sum{}, weight = all<V>(1);
    for (int k = 0; k < 14; ++k) {
        V size2{};
        for (const V& v : M.m) size2 = fused(v, v, size2);
        const B exponent = (((B)size2 >> 52) + 1) >> 1;  // of the size, 512 too large
        const V round = all<V>(0x1.8p52);
        sum = fused(weight, (V)((B)round + exponent) - (round + 512.0), sum);
        const V factor = (V)((1023 + 512 - exponent) << 52);
        for (V& v : M.m) v *= factor;
        M = product3(M, M), M = product3(M, M);
        weight *= all<V>(0.25);
    }
    return sum;
}

template <int W>
void cycle_averages(CycleTask& task, double* memory) {
    using V = Pack<W>;
    const CycleTask q = task;
    V* out = reinterpret_cast<V*>(memory);
    const CycleNewton<W> gait(q);
    const V* y = reinterpret_cast<const V*>(q.y);
    V* theta = reinterpret_cast<V*>(q.work);
    const int N = q.nodes;
    V turn{}, loss{}, mode[12] = {};
    for (int k = 0; k < N; k += 4) {  // heading by the integral of nu
        V by[4] = {};
        for (int j = 0; j < N; ++j)
            for (int i = 0; i < 4; ++i)
                by[i] = fused(all<V>(q.rows[k + i - j + N - 1].odd_integral), y[3 * j + 2], by[i]);
        for (int i = 0; i < 4; ++i) theta[k + i] = turn, turn += by[i];
    }
    for (int k = 0; k < N; ++k) {
        const V *u = y + 3 * k, x = u[0], z = u[1], nu = u[2];
        const auto at = [&](int field) { return gait.at(field, k); };
        const V spin = at(kWw) * nu + 2 * at(kW);
        loss +=
            at(kBxx) * x * x + at(kByy) * z * z + at(kArm2) * nu * spin + at(kLoss) +
            2 * (at(kBxy) * x * z + nu * (at(kBxw) * x + at(kByw) * z) + at(kBx) * x + at(kBy) * z);
        const double* wave = q.modes + 8 * k;
        const V arm = square_root(at(kArm2));
        for (int i = 0; i < 4; ++i) {
            mode[i] += all<V>(wave[i]) * x, mode[4 + i] += all<V>(wave[4 + i]) * z;
            mode[8 + i] += all<V>(wave[4 + i]) * arm * nu;
        }
    }
    V advance{};
    for (int k = 0; k < N; ++k) {  // axes half way between both ends' headings
        V s, c;
        sincos_near(theta[k] - 0.5 * turn, s, c);
        advance += c * y[3 * k] - s * y[3 * k + 1];
    }
    V tail{};
    for (const V& m : mode) tail += m * m;
    const V each = all<V>(1.0 / N);
    out[kAdvance] = advance * each, out[kHeading] = -0.5 * turn;
    out[kDissipated] = loss * each, out[kTail] = tail * each;
    Mat<V> P;
    for (int i = 0; i < 9; ++i) P[i] = out[kTransfer + i];
    out[kLogRadius] = log2_radius(P);
}

template <int W>
void cycle_refine(int N, const double* even, const double* odd, double* memory, double* scratch) {
    using V = Pack<W>;
    V *y = reinterpret_cast<V*>(memory), *middle = reinterpret_cast<V*>(scratch);
    for (int k = 0; k < N; ++k) {
        V x{}, z{}, nu{};
        for (int j = 0; j < N; ++j) {
            const V e = all<V>(even[k - j + N - 1]), o = all<V>(odd[k - j + N - 1]);
            x = fused(e, y[3 * j], x), z = fused(o, y[3 * j + 1], z);
            nu = fused(o, y[3 * j + 2], nu);
        }
        middle[3 * k] = x, middle[3 * k + 1] = z, middle[3 * k + 2] = nu;
    }
    for (int k = N - 1; k >= 0; --k)
        for (int c = 0; c < 3; ++c)
            y[6 * k + c] = y[3 * k + c], y[6 * k + 3 + c] = middle[3 * k + c];
}

template <int W>
void cycle_blend(int count, int values, const double* weight, const double* from, double* y) {
    using V = Pack<W>;
    const V* w = reinterpret_cast<const V*>(weight);
    for (int i = 0; i < values; ++i) {
        V sum{};
        for (int k = 0; k < count; ++k) sum = fused(w[k], all<V>(from[k * values + i]), sum);
        reinterpret_cast<V*>(y)[i] = sum;
    }
}

template <int W>
void cycle_newton(CycleTask& q, double* out) {
    CycleNewton<W>(q).step(reinterpret_cast<Pack<W>*>(out));
}

}  // namespace
}  // namespace serpenoid::kernels
