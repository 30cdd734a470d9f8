// Cholesky's factor of a small dense matrix, and the two solves with it.
#pragma once

#include <cmath>

#include "numerics/pack.hpp"

namespace serpenoid {

inline Pack pair(const double* x) { return *reinterpret_cast<const Pair*>(x); }

// to += a from
[[gnu::always_inline]] inline void add(double* sum, int size, double a, const double* term) {
    int i = 0;
    for (; i + 1 < size; i += 2) *reinterpret_cast<Pair*>(sum + i) += a * pair(term + i);
    if (i < size) sum[i] += a * term[i];
}

[[gnu::always_inline]] inline double dot(const double* a, const double* b, int size) {
    Pack sum{};
    int i = 0;
    for (; i + 1 < size; i += 2) sum += pair(a + i) * pair(b + i);
    return sum[0] + sum[1] + (i < size ? a[i] * b[i] : 0.0);
}

// In place, m = U^T U by the upper triangle of m, rows of `size`; U has reciprocals on its
// diagonal. A matrix that is not positive definite gives a factor that is not a number.
inline void cholesky(double* m, int size) {
    for (int k = 0; k < size; ++k) {
        double* row = m + k * size;
        const double inverse = 1 / std::sqrt(row[k]);
        row[k] = inverse;
        for (int i = k + 1; i < size; ++i) row[i] *= inverse;
        for (int i = k + 1; i < size; ++i) add(m + i * size + i, size - i, -row[i], row + i);
    }
}

// x becomes U^-T x.
inline void forward(const double* m, int size, double* x) {
    for (int i = 0; i < size; ++i) {
        const double* row = m + i * size;
        x[i] *= row[i];
        add(x + i + 1, size - i - 1, -x[i], row + i + 1);
    }
}

// x becomes U^-1 x.
inline void backward(const double* m, int size, double* x) {
    for (int i = size; i-- > 0;) {
        const double* row = m + i * size;
        x[i] = (x[i] - dot(row + i + 1, x + i + 1, size - i - 1)) * row[i];
    }
}

}  // namespace serpenoid
