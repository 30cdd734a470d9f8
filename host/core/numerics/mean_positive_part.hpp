// Mean over an element of the positive part of a polynomial known at the Gauss nodes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "numerics/gauss_rule.hpp"

namespace serpenoid {

// The polynomial through s values at the Gauss nodes, in powers of z = 2x - 1, for x in [0, 1].
template <int s>
class NodePolynomial {
  public:
    explicit NodePolynomial(const std::array<double, s>& values) {
        const auto& M = power_basis();
        for (int k = 0; k < s; ++k) {
            coefficient_[k] = 0;
            for (int j = 0; j < s; ++j) coefficient_[k] += M[k * s + j] * values[j];
        }
    }

    double operator()(double z) const {
        double sum = coefficient_[s - 1];
        for (int k = s - 2; k >= 0; --k) sum = sum * z + coefficient_[k];
        return sum;
    }

    // Integral from 0 to z.
    double primitive(double z) const {
        double sum = coefficient_[s - 1] / s;
        for (int k = s - 2; k >= 0; --k) sum = sum * z + coefficient_[k] / (k + 1);
        return sum * z;
    }

  private:
    // Column j: coefficients of the j-th Lagrange polynomial, by multiplying its factors out.
    static const std::array<double, s * s>& power_basis() {
        static const std::array<double, s * s> matrix = [] {
            const Gauss<s>& rule = Gauss<s>::get();
            std::array<double, s * s> M{};
            for (int j = 0; j < s; ++j) {
                std::array<double, s> c{1.0};
                int degree = 0;
                for (int k = 0; k < s; ++k) {
                    if (k == j) continue;
                    const double zk = 2 * rule.c[k] - 1, scale = 1 / (2 * (rule.c[j] - rule.c[k]));
                    ++degree;
                    for (int p = degree; p >= 0; --p)
                        c[p] = scale * ((p > 0 ? c[p - 1] : 0) - zk * (p < degree ? c[p] : 0));
                }
                for (int p = 0; p < s; ++p) M[p * s + j] = c[p];
            }
            return M;
        }();
        return matrix;
    }

    std::array<double, s> coefficient_;
};

// Root of f between a and b, where fa and fb differ in sign (Illinois' regula falsi).
template <class Function>
double bracketed_root(const Function& f, double a, double fa, double b, double fb) {
    const double tiny = 1e-14 * (std::fabs(fa) + std::fabs(fb));
    for (int i = 0; i < 60 && std::fabs(b - a) > 1e-15; ++i) {
        const double x = b - fb * (b - a) / (fb - fa), fx = f(x);
        if (std::fabs(fx) <= tiny) return x;
        if ((fx > 0) == (fb > 0))
            fa *= 0.5;
        else
            a = b, fa = fb;
        b = x, fb = fx;
    }
    return b;
}

// Roots between neighbouring nodes (the ends count as nodes) split the element, and each positive
// piece is integrated exactly. A pair of roots between two neighbours goes unseen until refined.
template <int s>
double mean_positive_part(const std::array<double, s>& values) {
    const Gauss<s>& rule = Gauss<s>::get();
    const NodePolynomial<s> p(values);
    std::array<double, s + 2> z, v;
    z[0] = -1, z[s + 1] = 1, v[0] = p(-1), v[s + 1] = p(1);
    for (int k = 0; k < s; ++k) z[k + 1] = 2 * rule.c[k] - 1, v[k + 1] = values[k];
    double sum = 0, from = p.primitive(-1);
    for (int k = 0; k <= s; ++k) {
        if ((v[k] > 0) == (v[k + 1] > 0)) continue;
        const double to = p.primitive(bracketed_root(p, z[k], v[k], z[k + 1], v[k + 1]));
        if (v[k] > 0) sum += to - from;
        from = to;
    }
    if (v[s + 1] > 0) sum += p.primitive(1) - from;
    return sum / 2;
}

}  // namespace serpenoid
