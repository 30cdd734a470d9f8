// Radau IIA collocation on [0, 1]: nodes, integration matrix, and what dense output needs.
#pragma once

#include <array>
#include <cmath>

#include "numerics/gauss_rule.hpp"

namespace serpenoid {

// s stages, the last at the end: order 2s - 1 there, L-stable.
//
// Between the ends, u (the polynomial of degree s through the start and the stages) has the rate
// of the system at the stages but not at the start: with the defect delta = u'(0) - f(0) its error
// is, to leading order, h delta bump(x), bump(x) = integral of prod (1 - x/c_k) from 0 to x.
// Taking that off gains an order and tells how large it was. bump vanishes at 1.
template <int s>
struct RadauRule {
    std::array<double, s> c;
    std::array<double, s * s> a;   // a[j*s + k] = integral of the k-th Lagrange polynomial, 0..c_j
    std::array<double, s> at0;     // those polynomials at 0
    std::array<double, s> slope0;  // u'(0) = sum slope0_k (Y_k - y_0)
    double bump_height;            // largest |bump|

    static const RadauRule& get() {
        static const RadauRule instance;
        return instance;
    }

    double bump(double x) const {
        const Gauss<s>& gauss = Gauss<s>::get();
        double sum = 0;
        for (int q = 0; q < s; ++q) {
            double product = 1;
            for (int k = 0; k < s; ++k) product *= 1 - x * gauss.c[q] / c[k];
            sum += gauss.b[q] * product;
        }
        return x * sum;
    }

    // Weights of the stages, less the start, in u(x) - y_0.
    std::array<double, s> dense(double x) const {
        std::array<double, s> w;
        for (int k = 0; k < s; ++k) w[k] = lagrange(k, x) * x / c[k];
        return w;
    }

  private:
    RadauRule() {
        const Gauss<s>& gauss = Gauss<s>::get();
        for (int k = 0; k < s; ++k) c[k] = node(s - 1 - k);
        for (int k = 0; k < s; ++k) {
            at0[k] = lagrange(k, 0), slope0[k] = at0[k] / c[k];
            for (int j = 0; j < s; ++j) {
                a[j * s + k] = 0;
                for (int q = 0; q < s; ++q)
                    a[j * s + k] += c[j] * gauss.b[q] * lagrange(k, c[j] * gauss.c[q]);
            }
        }
        bump_height = 0;
        for (int i = 1; i < 200; ++i)
            bump_height = std::fmax(bump_height, std::fabs(bump(i / 200.0)));
    }

    double lagrange(int k, double x) const {
        double product = 1;
        for (int j = 0; j < s; ++j)
            if (j != k) product *= (x - c[j]) / (c[k] - c[j]);
        return product;
    }

    // The i-th zero of P_s - P_{s-1} from the right, by Newton's method; the first is the end.
    static double node(int i) {
        if (i == 0) return 1;
        double x = std::cos(2 * M_PI * i / (2 * s - 1));
        for (int iteration = 0; iteration < 100; ++iteration) {
            double p0 = 1, p1 = x, d0 = 0, d1 = 1;
            for (int k = 2; k <= s; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k,
                             d2 = d0 + (2 * k - 1) * p1;
                p0 = p1, p1 = p2, d0 = d1, d1 = d2;
            }
            const double step = (p1 - p0) / (d1 - d0);
            x -= step;
            if (std::fabs(step) < 1e-16) break;
        }
        return (1 + x) / 2;
    }
};

}  // namespace serpenoid
