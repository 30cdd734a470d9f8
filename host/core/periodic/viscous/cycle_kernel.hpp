// Periodic states on viscous ground by packs: Newton's steps, averages.
//
// The derivation stands in spectral.hpp.
#pragma once

#include "numerics/pack.hpp"
#include "periodic/viscous/cycle_table.hpp"

namespace serpenoid {
namespace {

inline Pack square_root(Pack x) {
    for (int j = 0; j < kPack; ++j) x[j] = std::sqrt(x[j]);
    return x;
}

struct PackMat {
    Pack m[9];
    Pack& operator[](int i) { return m[i]; }
    const Pack& operator[](int i) const { return m[i]; }
};

inline PackMat product3(const PackMat& a, const PackMat& b) {
    PackMat c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            c[3 * i + j] = a[3 * i + 2] * b[6 + j] + (a[3 * i + 1] * b[3 + j] + a[3 * i] * b[j]);
    return c;
}

// a b + c
inline PackMat product3(const PackMat& a, const PackMat& b, PackMat c) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
    return c;
}

inline void product3(const PackMat& a, const Pack* x, Pack* to) {
    for (int i = 0; i < 3; ++i)
        to[i] = a[3 * i + 2] * x[2] + (a[3 * i + 1] * x[1] + a[3 * i] * x[0]);
}

inline PackMat inverse3(const PackMat& a) {
    const Pack c0 = a[4] * a[8] - a[5] * a[7], c1 = a[5] * a[6] - a[3] * a[8],
               c2 = a[3] * a[7] - a[4] * a[6];
    const Pack f = 1.0 / (a[0] * c0 + (a[1] * c1 + a[2] * c2));
    return {{f * c0, f * (a[2] * a[7] - a[1] * a[8]), f * (a[1] * a[5] - a[2] * a[4]), f * c1,
             f * (a[0] * a[8] - a[2] * a[6]), f * (a[2] * a[3] - a[0] * a[5]), f * c2,
             f * (a[1] * a[6] - a[0] * a[7]), f * (a[0] * a[4] - a[1] * a[3])}};
}

// Half a cycle later a matrix is its mirror image: entries between x and the other two change sign.
inline PackMat mirrored(PackMat a) {
    a[1] = -a[1], a[2] = -a[2], a[3] = -a[3], a[6] = -a[6];
    return a;
}

class CycleNewton {
  public:
    explicit CycleNewton(const CycleTask& task)
        : q(task),
          N(task.nodes),
          y(reinterpret_cast<Pack*>(task.y)),
          g(*reinterpret_cast<const Pack*>(task.g)),
          f(reinterpret_cast<Pack*>(task.work)),
          r(f + 3 * N),
          miss(r + 3 * N),
          cell(reinterpret_cast<Cell*>(miss + 3 * N)) {}

    void step(Pack* out) {
        for (int k = 0; k < N; ++k) slope(k, f + 3 * k);
        residuals();
        for (int k = 0; k < N; ++k) linearise(k);
        Pack start[3];
        chain(out + kTransfer, start);
        move(start, out);
    }

    // f = dy/dtau at a node.
    void slope(int k, Pack* to) const {
        const Pack *u = y + 3 * k, x = u[0], z = u[1], nu = u[2];
        const auto sum = [&](int a, int b, int c, int d) {
            return (at(a, k) * x + (at(b, k) * z + (at(c, k) * nu + at(d, k))));
        };
        to[0] = nu * z - g * sum(kBxx, kBxy, kBxw, kBx);
        to[1] = -(nu * x + g * sum(kBxy, kByy, kByw, kBy));
        to[2] = -(g * sum(kWx, kWy, kWw, kW) + (at(kJ1, k) * nu + at(kK1, k)));
    }

    Pack at(int field, int k) const { return all(q.node[field * N + k]); }

  private:
    // The matrices of Hermite's rule at a node, then of the cell that begins there.
    struct Cell {
        PackMat half, plus, inverse;
        Pack correction[3];
    };

    // A = df/dy there, with `fields` the table of the matrix or of its derivative.
    PackMat matrix(int k, int fields, Pack x, Pack z, Pack nu) const {
        const Pack less = -g;
        const auto b = [&](int i) { return less * at(fields + i, k); };
        const auto with = [&](int i, Pack c) { return (less * at(fields + i, k) + c); };
        return {{b(kBxx), with(kBxy, nu), with(kBxw, z), with(kBxy, -nu), b(kByy), with(kByw, -x),
                 b(kWx), b(kWy), with(kWw, -at(fields + kJ1, k))}};
    }

    void linearise(int k) {
        const Pack *u = y + 3 * k, *du = f + 3 * k;
        const PackMat A = matrix(k, 0, u[0], u[1], u[2]);
        const PackMat AA = product3(A, A, matrix(k, kSlope, du[0], du[1], du[2]));
        const Pack h2 = all(q.step / 2), h12 = all(q.step * q.step / 12);
        PackMat minus;
        for (int i = 0; i < 9; ++i) {
            const Pack B = i % 4 ? h12 * AA[i] : (h12 * AA[i] + all(1));
            const Pack H = h2 * A[i];
            cell[k].half[i] = H, cell[k].plus[i] = B + H, minus[i] = B - H;
        }
        cell[k].inverse = inverse3(minus);
    }

    // Sums and differences of a pair (spectral_row.hpp), by component.
    struct Pair {
        Pack u[2][3], f[2][3];
    };

    // The pairs use the memory of the cells, which are filled later.
    Pair* fold() const {
        Pair* pair = reinterpret_cast<Pair*>(cell);
        for (int j = 0; j <= N / 2; ++j)
            for (int c = 0; c < 3; ++c) {
                const Pack u = y[3 * j + c], du = f[3 * j + c];
                const Pack mirror = y[3 * (N - 1 - j) + c];
                pair[j].u[0][c] = u + mirror, pair[j].u[1][c] = u - mirror;
                const bool alone = j == 0 || j == N / 2;
                const Pack other = alone ? Pack{} : f[3 * (N - j) + c];
                pair[j].f[0][c] = du + other, pair[j].f[1][c] = du - other;
            }
        return pair;
    }

    // r = f - y' at the nodes; miss: the integral of f over each cell less the change of y.
    void residuals() {
        const Pair* pairs = fold();
        for (int k = 0; k < N / 2; ++k) {
            Pack d[2][3] = {}, s[2][3] = {};
            for (int j = 0; j <= N / 2; ++j) {
                const FoldedRow& row = q.folded[k * (N / 2 + 1) + j];
                for (int i = 0; i < 2; ++i)
                    for (int c = 0; c < 3; ++c) {
                        const Pack slope = all(c ? row.odd_slope[i] : row.even_slope[i]);
                        const Pack part = all(c ? row.odd_integral[i] : row.even_integral[i]);
                        d[i][c] += slope * pairs[j].u[i][c];
                        s[i][c] += part * pairs[j].f[i][c];
                    }
            }
            for (int c = 0; c < 3; ++c) {
                residual(k, c, d[1][c] + d[0][c], s[0][c] + s[1][c]);
                residual(N - 1 - k, c, d[1][c] - d[0][c], s[0][c] - s[1][c]);
            }
        }
    }

    void residual(int k, int c, Pack slope, Pack integral) {
        const int a = 3 * k + c;
        const Pack next = k + 1 < N ? y[a + 3] : c ? -y[c] : y[c];
        r[a] = f[a] - slope, miss[a] = integral - (next - y[a]);
    }

    // Changes of all nodes as functions of the first one's: transfer matrices and their product.
    // The symmetry of the cycle gives the first one.
    void chain(Pack* transfer, Pack* start) {
        PackMat P = {{all(1), Pack{}, Pack{}, Pack{}, all(1), Pack{}, Pack{}, Pack{}, all(1)}};
        Pack p[3] = {}, begin[3], from[3];
        product3(cell[0].half, r, begin);
        for (int c = 0; c < 3; ++c) from[c] = begin[c];
        for (int k = 0; k < N; ++k) {
            const bool last = k + 1 == N;
            const Cell& next = cell[last ? 0 : k + 1];
            Pack to[3] = {begin[0], -begin[1], -begin[2]}, right[3];
            if (!last) product3(next.half, r + 3 * (k + 1), to);
            const Pack h6 = all(q.step / 6);
            for (int c = 0; c < 3; ++c) {
                right[c] = h6 * (from[c] - to[c]) + miss[3 * k + c];
                from[c] = to[c];
            }
            const PackMat inverse = last ? mirrored(first_) : next.inverse;
            if (k == 0) first_ = cell[0].inverse;
            product3(inverse, right, cell[k].correction);
            cell[k].inverse = product3(inverse, cell[k].plus);  // from now on the transfer matrix
            P = product3(cell[k].inverse, P);
            Pack q3[3];
            product3(cell[k].inverse, p, q3);
            for (int c = 0; c < 3; ++c) p[c] = q3[c] + cell[k].correction[c];
        }
        PackMat C;
        for (int i = 0; i < 9; ++i) {
            transfer[i] = i < 3 ? P[i] : -P[i];
            C[i] = (i % 4 ? 0.0 : i ? -1.0 : 1.0) - P[i];
        }
        product3(inverse3(C), p, start);
    }

    void move(Pack* d, Pack* out) {
        Pack change{}, size{};
        for (int k = 0; k < N; ++k) {
            Pack* u = y + 3 * k;
            for (int c = 0; c < 3; ++c) u[c] += d[c];
            const Pack arm = at(kArm2, k);
            change += d[0] * d[0] + d[1] * d[1] + arm * d[2] * d[2];
            size += u[0] * u[0] + u[1] * u[1] + arm * (u[2] * u[2] + at(kSpin2, k));
            Pack next[3];
            product3(cell[k].inverse, d, next);
            for (int c = 0; c < 3; ++c) d[c] = next[c] + cell[k].correction[c];
        }
        out[kChange2] = change, out[kSize2] = size;
    }

    const CycleTask q;  // a copy: no store of packs can change it
    int N;
    Pack* y;
    Pack g;
    Pack *f, *r, *miss;
    Cell* cell;
    PackMat first_;
};

// Binary logarithm of the largest eigenvalue's size: of ||M^k||^(1/k) for k = 4^13. Scaling is by
// powers of two, read from and put into the exponent's bits.
inline Pack log2_radius(PackMat M) {
    Pack sum{}, weight = all(1);
    for (int k = 0; k < 14; ++k) {
        Pack size2{};
        for (const Pack& v : M.m) size2 += v * v;
        const PackBits exponent = (((PackBits)size2 >> 52) + 1) >> 1;  // of the size, 512 too large
        const Pack round = all(0x1.8p52);
        sum += weight * ((Pack)((PackBits)round + exponent) - (round + 512.0));
        const Pack factor = (Pack)((1023 + 512 - exponent) << 52);
        for (Pack& v : M.m) v *= factor;
        M = product3(M, M), M = product3(M, M);
        weight *= all(0.25);
    }
    return sum;
}

void cycle_averages(CycleTask& task, double* memory) {
    const CycleTask q = task;
    Pack* out = reinterpret_cast<Pack*>(memory);
    const CycleNewton gait(q);
    const Pack* y = reinterpret_cast<const Pack*>(q.y);
    Pack* theta = reinterpret_cast<Pack*>(q.work);
    const int N = q.nodes;
    Pack turn{}, loss{}, mode[12] = {};
    for (int k = 0; k < N; k += 4) {  // heading by the integral of nu
        Pack by[4] = {};
        for (int j = 0; j < N; ++j)
            for (int i = 0; i < 4; ++i)
                by[i] += all(q.rows[k + i - j + N - 1].odd_integral) * y[3 * j + 2];
        for (int i = 0; i < 4; ++i) theta[k + i] = turn, turn += by[i];
    }
    for (int k = 0; k < N; ++k) {
        const Pack *u = y + 3 * k, x = u[0], z = u[1], nu = u[2];
        const auto at = [&](int field) { return gait.at(field, k); };
        const Pack spin = at(kWw) * nu + 2 * at(kW);
        loss +=
            at(kBxx) * x * x + at(kByy) * z * z + at(kArm2) * nu * spin + at(kLoss) +
            2 * (at(kBxy) * x * z + nu * (at(kBxw) * x + at(kByw) * z) + at(kBx) * x + at(kBy) * z);
        const double* wave = q.modes + 8 * k;
        const Pack arm = square_root(at(kArm2));
        for (int i = 0; i < 4; ++i) {
            mode[i] += all(wave[i]) * x, mode[4 + i] += all(wave[4 + i]) * z;
            mode[8 + i] += all(wave[4 + i]) * arm * nu;
        }
    }
    Pack advance{};
    for (int k = 0; k < N; ++k) {  // axes half way between both ends' headings
        Pack s, c;
        sincos(theta[k] - 0.5 * turn, s, c);
        advance += c * y[3 * k] - s * y[3 * k + 1];
    }
    Pack tail{};
    for (const Pack& m : mode) tail += m * m;
    const Pack each = all(1.0 / N);
    out[kAdvance] = advance * each, out[kHeading] = -0.5 * turn;
    out[kDissipated] = loss * each, out[kTail] = tail * each;
    PackMat P;
    for (int i = 0; i < 9; ++i) P[i] = out[kTransfer + i];
    out[kLogRadius] = log2_radius(P);
}

void cycle_refine(int N, const double* even, const double* odd, double* memory, double* scratch) {
    Pack *y = reinterpret_cast<Pack*>(memory), *middle = reinterpret_cast<Pack*>(scratch);
    for (int k = 0; k < N; ++k) {
        Pack x{}, z{}, nu{};
        for (int j = 0; j < N; ++j) {
            const Pack e = all(even[k - j + N - 1]), o = all(odd[k - j + N - 1]);
            x += e * y[3 * j], z += o * y[3 * j + 1];
            nu += o * y[3 * j + 2];
        }
        middle[3 * k] = x, middle[3 * k + 1] = z, middle[3 * k + 2] = nu;
    }
    for (int k = N - 1; k >= 0; --k)
        for (int c = 0; c < 3; ++c)
            y[6 * k + c] = y[3 * k + c], y[6 * k + 3 + c] = middle[3 * k + c];
}

void cycle_blend(int count, int values, const double* weight, const double* from, double* y) {
    const Pack* w = reinterpret_cast<const Pack*>(weight);
    for (int i = 0; i < values; ++i) {
        Pack sum{};
        for (int k = 0; k < count; ++k) sum += w[k] * all(from[k * values + i]);
        reinterpret_cast<Pack*>(y)[i] = sum;
    }
}

void cycle_newton(CycleTask& q, double* out) { CycleNewton(q).step(reinterpret_cast<Pack*>(out)); }

}  // namespace
}  // namespace serpenoid
