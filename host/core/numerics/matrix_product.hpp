// Products of many 3x3 matrices without underflow: exponential, largest eigenvalue.
#pragma once

#include <algorithm>
#include <cmath>

#include "numerics/dense.hpp"

namespace serpenoid {

inline double largest(const Mat3& M) {
    double most = 0;
    for (const double v : M) most = std::max(most, std::fabs(v));
    return most;
}

// Divide by the largest entry; returns its logarithm (0 for a matrix of zeros).
inline double normalise(Mat3& M) {
    const double size = largest(M);
    if (!(size > 0)) return 0;
    for (double& v : M) v /= size;
    return std::log(size);
}

// P becomes exp(A) P over a factor whose logarithm is returned: Taylor's series of A over a power
// of two, squared again and normalised each time. The norm does not depend on units.
inline double multiply_exponential(Mat3 A, Mat3& P) {
    double norm = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) norm = std::max(norm, std::fabs(A[3 * i + j] * A[3 * j + i]));
    norm = std::sqrt(norm);
    int squarings = 0;
    while (std::ldexp(norm, -squarings) > 0.25 && squarings < 1000) ++squarings;
    for (double& a : A) a = std::ldexp(a, -squarings);
    Mat3 E = identity3();
    for (int k = 12; k >= 1; --k) {
        E = multiply(A, E);
        for (int i = 0; i < 9; ++i) E[i] = E[i] / k + (i % 4 == 0);
    }
    double scale = 0;
    for (int k = 0; k < squarings; ++k) {
        E = multiply(E, E);
        scale = 2 * scale + normalise(E);
    }
    P = multiply(E, P);
    return scale + normalise(P);
}

// Logarithm of the size of the largest eigenvalue: of ||M^k||^(1/k) for k = 2^30.
inline double log_spectral_radius(Mat3 M) {
    double scale = normalise(M), weight = 1;
    if (largest(M) == 0) return -HUGE_VAL;
    for (int k = 0; k < 30; ++k) {
        M = multiply(M, M);
        weight /= 2;
        scale += weight * normalise(M);
        if (largest(M) == 0) return -HUGE_VAL;
    }
    return scale;
}

}  // namespace serpenoid
