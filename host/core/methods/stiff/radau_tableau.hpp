// Radau IIA with three stages (order 5, L-stable) along the eigenvectors of its matrix.
//
// With A the matrix of the method, stage increments Z of the places obey  V = A^-1 Z / h,
// A^-1 (V - v_0) / h = acceleration.  A^-1 has one real and two complex eigenvalues, the zeros of
// z^3 - 9 z^2 + 36 z - 60; along its eigenvectors the three stages separate (Hairer and Wanner,
// Solving Ordinary Differential Equations II, IV.8).
#pragma once

#include <array>
#include <cmath>

#include "numerics/block_tridiagonal.hpp"
#include "numerics/radau_collocation.hpp"

namespace serpenoid {

template <class Scalar>
using Triple = std::array<Scalar, 3>;

struct RadauTableau {
    RadauTableau();

    const RadauRule<3>& rule = RadauRule<3>::get();
    double gamma;  // the real eigenvalue and its vectors
    Triple<double> right, left;
    Complex lambda;  // one of the complex pair
    Triple<Complex> right_pair, left_pair;
    Triple<double> error;  // of the embedded formula: f_0 + sum error_i Z_i / h
};

template <class Scalar, class Other>
Scalar dot(const Triple<Scalar>& a, const Triple<Other>& b) {
    return b[0] * a[0] + b[1] * a[1] + b[2] * a[2];
}

// A vector that (rows - lambda) sends to zero: across two of its rows.
template <class Scalar>
Triple<Scalar> null_vector(const std::array<double, 9>& m, Scalar lambda, bool left) {
    const auto entry = [&](int i, int j) {
        return Scalar(left ? m[3 * j + i] : m[3 * i + j]) - (i == j ? lambda : Scalar(0));
    };
    Triple<Scalar> v;
    for (int j = 0; j < 3; ++j) {
        const int a = (j + 1) % 3, b = (j + 2) % 3;
        v[j] = entry(0, a) * entry(1, b) - entry(0, b) * entry(1, a);
    }
    return v;
}

inline RadauTableau::RadauTableau() {
    const double u = std::cbrt(81.0), w = std::cbrt(9.0);
    const double p = (12 - u + w) / 60, q = (u + w) * std::sqrt(3.0) / 60;
    gamma = 30 / (6 + u - w);
    lambda = reciprocal(Complex(p, -q));
    right = null_vector(rule.rate, gamma, false), left = null_vector(rule.rate, gamma, true);
    right_pair = null_vector(rule.rate, lambda, false);
    left_pair = null_vector(rule.rate, lambda, true);
    const double f = 1 / right[2], g = right[2] / dot(left, right);
    for (double& x : right) x = f * x;
    for (double& x : left) x = g * x;
    const Complex F = reciprocal(right_pair[2]);
    const Complex G = right_pair[2] * reciprocal(dot(left_pair, right_pair));
    for (Complex& x : right_pair) x = F * x;
    for (Complex& x : left_pair) x = G * x;
    const double r = std::sqrt(6.0);
    error = {-(13 + 7 * r) / 3, (-13 + 7 * r) / 3, -1.0 / 3};
}

}  // namespace serpenoid
