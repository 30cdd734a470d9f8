// Products of many 3x3 matrices without underflow: the largest eigenvalue.
#pragma once

#include <algorithm>
#include <cmath>

#include "numerics/dense.hpp"

namespace serpenoid {

inline double largest(const Mat3& M) {
    double size = 0;
    for (const double v : M) size = std::max(size, std::fabs(v));
    return size;
}

// Divide by the largest entry; returns its logarithm (0 for a matrix of zeros).
inline double normalise(Mat3& M) {
    const double size = largest(M);
    if (!(size > 0)) return 0;
    for (double& v : M) v /= size;
    return std::log(size);
}

// Logarithm of the size of the largest eigenvalue: of ||M^k||^(1/k) for k = 2^30.
inline double log_spectral_radius(Mat3 M) {
    double scale = normalise(M), weight = 1;
    if (largest(M) == 0) return -HUGE_VAL;
    for (int k = 0; k < 30; ++k) {
        const Mat3 previous = M;
        M = multiply(M, M);
        weight /= 2;
        const double step = normalise(M);
        scale += weight * step;
        if (largest(M) == 0) return -HUGE_VAL;
        Mat3 change;
        for (int i = 0; i < 9; ++i) change[i] = M[i] - previous[i];
        if (largest(change) < 1e-15)
            return scale + weight * step;  // every further step is this one
    }
    return scale;
}

}  // namespace serpenoid
