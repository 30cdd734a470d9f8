// Dense linear algebra for small systems: LU factors with partial pivoting, 3 x 3 matrices.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>
#include <vector>

namespace serpenoid {

// Overwrite b (n rows of `columns`, row major) with the solution of A x = b; A is destroyed.
// Returns false when A is singular to working precision. Sizes are fixed, so that loops unroll.
template <int n, int columns>
bool solve_dense(double* A, double* b) {
    for (int k = 0; k < n; ++k) {
        int pivot = k;
        for (int i = k + 1; i < n; ++i)
            if (std::fabs(A[i * n + k]) > std::fabs(A[pivot * n + k])) pivot = i;
        if (!(std::fabs(A[pivot * n + k]) > 0)) return false;
        if (pivot != k) {
            for (int j = k; j < n; ++j) std::swap(A[k * n + j], A[pivot * n + j]);
            for (int j = 0; j < columns; ++j) std::swap(b[k * columns + j], b[pivot * columns + j]);
        }
        const double inverse = 1.0 / A[k * n + k];
        const double* __restrict above = A + k * n, * __restrict right = b + k * columns;
        for (int i = k + 1; i < n; ++i) {
            double* __restrict row = A + i * n, * __restrict right_row = b + i * columns;
            const double factor = row[k] * inverse;
            if (factor == 0) continue;
            for (int j = k + 1; j < n; ++j) row[j] -= factor * above[j];
            for (int j = 0; j < columns; ++j) right_row[j] -= factor * right[j];
        }
    }
    for (int k = n - 1; k >= 0; --k) {
        const double inverse = 1.0 / A[k * n + k];
        for (int j = 0; j < columns; ++j) {
            double sum = b[k * columns + j];
            for (int i = k + 1; i < n; ++i) sum -= A[k * n + i] * b[i * columns + j];
            b[k * columns + j] = sum * inverse;
        }
    }
    return true;
}

// LU factors of a matrix whose size is known only at run time, for any number of right sides.
// Stored by columns, so that inner loops run over neighbours in memory.
template <class Scalar>
class DenseFactors {
  public:
    // A zero matrix of this size, by columns, for the caller to fill.
    std::vector<Scalar>& begin(int size) {
        n_ = size;
        columns_.assign(size * size, Scalar{});
        swapped_.resize(size);
        return columns_;
    }
    // False if the matrix is singular.
    bool factor() {
        for (int k = 0; k < n_; ++k) {
            Scalar* pivots = column(k);
            int pivot = k;
            for (int i = k + 1; i < n_; ++i)
                if (std::norm(pivots[i]) > std::norm(pivots[pivot])) pivot = i;
            swapped_[k] = pivot;
            if (!(std::norm(pivots[pivot]) > 0)) return false;
            for (int j = 0; j < n_ && pivot != k; ++j) std::swap(column(j)[k], column(j)[pivot]);
            const Scalar inverse = Scalar{1} / pivots[k];
            for (int i = k + 1; i < n_; ++i) pivots[i] *= inverse;
            for (int j = k + 1; j < n_; ++j) {
                Scalar* reduced = column(j);
                for (int i = k + 1; i < n_; ++i) reduced[i] -= reduced[k] * pivots[i];
            }
        }
        return true;
    }
    // Overwrite x, the right side, with the solution.
    void solve(Scalar* x) {
        for (int k = 0; k < n_; ++k) std::swap(x[k], x[swapped_[k]]);
        for (int k = 0; k < n_; ++k)
            for (int i = k + 1; i < n_; ++i) x[i] -= column(k)[i] * x[k];
        for (int k = n_ - 1; k >= 0; --k) {
            x[k] /= column(k)[k];
            for (int i = 0; i < k; ++i) x[i] -= column(k)[i] * x[k];
        }
    }

  private:
    Scalar* column(int k) { return &columns_[k * n_]; }
    int n_ = 0;
    std::vector<Scalar> columns_;
    std::vector<int> swapped_;
};

using Vec3 = std::array<double, 3>;
using Mat3 = std::array<double, 9>;  // row major

inline Mat3 identity3() { return {1, 0, 0, 0, 1, 0, 0, 0, 1}; }

template <class Real>
std::array<Real, 9> multiply(const std::array<Real, 9>& a, const std::array<Real, 9>& b) {
    std::array<Real, 9> c{};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            for (int j = 0; j < 3; ++j) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
    return c;
}

template <class Real>
std::array<Real, 3> multiply(const std::array<Real, 9>& a, const std::array<Real, 3>& x) {
    std::array<Real, 3> y{};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) y[i] += a[3 * i + j] * x[j];
    return y;
}

// The inverse by cofactors; usable for packs of matrices, for which rows cannot be exchanged.
template <class Real>
std::array<Real, 9> inverse3(const std::array<Real, 9>& a) {
    const Real c0 = a[4] * a[8] - a[5] * a[7], c1 = a[5] * a[6] - a[3] * a[8],
               c2 = a[3] * a[7] - a[4] * a[6];
    const Real f = 1.0 / (a[0] * c0 + (a[1] * c1 + a[2] * c2));
    return {f * c0, f * (a[2] * a[7] - a[1] * a[8]), f * (a[1] * a[5] - a[2] * a[4]),
            f * c1, f * (a[0] * a[8] - a[2] * a[6]), f * (a[2] * a[3] - a[0] * a[5]),
            f * c2, f * (a[1] * a[6] - a[0] * a[7]), f * (a[0] * a[4] - a[1] * a[3])};
}

}  // namespace serpenoid
