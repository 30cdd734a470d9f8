// Gauss-Legendre collocation on [0, 1]: nodes, weights, integration matrix, interpolation.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace serpenoid {

// s stages: order 2s at the ends of an element, A-stable, symmetric.
template <int s>
struct Gauss {
    std::array<double, s> c, b, barycentric;
    std::array<double, s * s> a;  // a[j*s + k] = integral of the k-th Lagrange polynomial, 0..c_j

    static const Gauss& get() {
        static const Gauss instance;
        return instance;
    }

    // Values of the s Lagrange polynomials at x.
    std::array<double, s> lagrange(double x) const {
        std::array<double, s> w;
        double sum = 0;
        for (int k = 0; k < s; ++k) {
            if (x == c[k]) {
                w.fill(0);
                w[k] = 1;
                return w;
            }
            w[k] = barycentric[k] / (x - c[k]);
            sum += w[k];
        }
        for (double& v : w) v /= sum;
        return w;
    }

  private:
    Gauss() {
        for (int i = 0; i < s; ++i) node(i);
        for (int k = 0; k < s; ++k) {
            double product = 1;
            for (int j = 0; j < s; ++j)
                if (j != k) product *= c[k] - c[j];
            barycentric[k] = 1 / product;
        }
        for (int j = 0; j < s; ++j) {  // the rule itself integrates degree s - 1 exactly
            for (int k = 0; k < s; ++k) a[j * s + k] = 0;
            for (int q = 0; q < s; ++q) {
                const auto value = lagrange(c[j] * c[q]);
                for (int k = 0; k < s; ++k) a[j * s + k] += c[j] * b[q] * value[k];
            }
        }
    }

    // The i-th root of the Legendre polynomial P_s by Newton's method, and its weight.
    void node(int i) {
        double x = -std::cos(std::numbers::pi * (i + 0.75) / (s + 0.5)), slope = 1;
        for (int iteration = 0; iteration < 100; ++iteration) {
            double p0 = 1, p1 = x;
            for (int k = 2; k <= s; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = s * (x * p1 - p0) / (x * x - 1);
            const double step = p1 / slope;
            x -= step;
            if (std::fabs(step) < 1e-16) break;
        }
        c[i] = (1 + x) / 2;
        b[i] = 1 / ((1 - x * x) * slope * slope);
    }
};

}  // namespace serpenoid
