// Coefficients of Radau IIA with three stages (order 5, L-stable), from their definitions.
//
// Nodes c are the zeros of d^2/dx^2 [x^2 (x-1)^3]. With A the matrix of the method, stage
// increments Z of the places obey  V = A^-1 Z / h,  A^-1 (V - v_0) / h = acceleration.  A^-1 has
// one real and two complex eigenvalues, the zeros of z^3 - 9 z^2 + 36 z - 60; along its
// eigenvectors the three stages separate (Hairer and Wanner, Solving Ordinary Differential
// Equations II, IV.8).
#pragma once

#include <array>
#include <cmath>

#include "numerics/block_tridiagonal.hpp"

namespace serpenoid {

template <class Scalar>
using Triple = std::array<Scalar, 3>;

struct RadauTableau {
    RadauTableau();

    Triple<double> node;
    std::array<Triple<double>, 3> matrix;   // A
    std::array<Triple<double>, 3> inverse;  // A^-1
    double gamma;                           // the real eigenvalue and its vectors
    Triple<double> right, left;
    Complex lambda;  // one of the complex pair
    Triple<Complex> right_pair, left_pair;
    Triple<double> error;   // of the embedded formula: f_0 + sum error_i Z_i / h
    Triple<double> behind;  // the quadratic through the stages, at the step's start
};

template <class Scalar, class Other>
Scalar dot(const Triple<Scalar>& a, const Triple<Other>& b) {
    return b[0] * a[0] + b[1] * a[1] + b[2] * a[2];
}

// A vector that (rows - lambda) sends to zero: across two of its rows.
template <class Scalar>
Triple<Scalar> null_vector(const std::array<Triple<double>, 3>& m, Scalar lambda, bool left) {
    const auto entry = [&](int i, int j) {
        return Scalar(left ? m[j][i] : m[i][j]) - (i == j ? lambda : Scalar(0));
    };
    Triple<Scalar> v;
    for (int j = 0; j < 3; ++j) {
        const int a = (j + 1) % 3, b = (j + 2) % 3;
        v[j] = entry(0, a) * entry(1, b) - entry(0, b) * entry(1, a);
    }
    return v;
}

inline RadauTableau::RadauTableau() {
    const double r = std::sqrt(6.0);
    node = {(4 - r) / 10, (4 + r) / 10, 1};
    // Lagrange's quadratics of the nodes: A has their integrals; A^-1 has the derivatives, at the
    // nodes, of the cubics that are x/c times these
    for (int j = 0; j < 3; ++j) {
        const double a = node[(j + 1) % 3], b = node[(j + 2) % 3], c = node[j];
        const double scale = 1 / ((c - a) * (c - b));
        for (int i = 0; i < 3; ++i) {
            const double x = node[i];
            matrix[i][j] = scale * x * (x * (x / 3 - (a + b) / 2) + a * b);
            inverse[i][j] = scale / c * ((x - a) * (x - b) + x * (x - b) + x * (x - a));
        }
        behind[j] = a * b / ((c - a) * (c - b));
    }
    const double u = std::cbrt(81.0), w = std::cbrt(9.0);
    const double p = (12 - u + w) / 60, q = (u + w) * std::sqrt(3.0) / 60;
    gamma = 30 / (6 + u - w);
    lambda = reciprocal(Complex(p, -q));
    right = null_vector(inverse, gamma, false), left = null_vector(inverse, gamma, true);
    right_pair = null_vector(inverse, lambda, false);
    left_pair = null_vector(inverse, lambda, true);
    const double f = 1 / right[2], g = right[2] / dot(left, right);
    for (double& x : right) x = f * x;
    for (double& x : left) x = g * x;
    const Complex F = reciprocal(right_pair[2]);
    const Complex G = right_pair[2] * reciprocal(dot(left_pair, right_pair));
    for (Complex& x : right_pair) x = F * x;
    for (Complex& x : left_pair) x = G * x;
    error = {-(13 + 7 * r) / 3, (-13 + 7 * r) / 3, -1.0 / 3};
}

}  // namespace serpenoid
