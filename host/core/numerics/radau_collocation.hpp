// Radau IIA collocation on [0, 1]: nodes, integration matrix, and weights for dense output.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "numerics/dense.hpp"

namespace serpenoid {

// s stages, of which the last is at x = 1. Order 2s - 1 at x = 1; L-stable.
template <int s>
struct RadauRule {
    std::array<double, s> c;
    std::array<double, s * s> a;  // a[j*s + k] = integral of the k-th Lagrange polynomial, 0..c_j
    std::array<double, s * s> rate;  // u'(c_j) = sum rate_jk (Y_k - y_0): the inverse of a

    static const RadauRule& get() {
        static const RadauRule instance;
        return instance;
    }

    // u(x) = sum w_k Y_k for the polynomial u through the stages.
    std::array<double, s> weights(double x) const {
        std::array<double, s> w = scale_;
        for (int k = 0; k < s; ++k)
            for (int j = 0; j < s; ++j)
                if (j != k) w[k] *= x - c[j];
        return w;
    }

    // u(x) - y_0 = sum w_k (Y_k - y_0) for the polynomial u through the start and the stages.
    std::array<double, s> dense(double x) const {
        auto w = weights(x);
        for (int k = 0; k < s; ++k) w[k] *= x * inverse_[k];
        return w;
    }

  private:
    // The matrix a follows from the condition that powers of x below s are integrated exactly.
    RadauRule() {
        for (int k = 0; k < s; ++k) c[k] = node(s - 1 - k);
        std::array<double, s * s> powers{}, integrals{};
        for (int k = 0; k < s; ++k) {
            double power = 1, product = 1;
            for (int q = 0; q < s; ++q) {
                powers[q * s + k] = power;
                power *= c[k];
                integrals[q * s + k] = power / (q + 1);
                product *= q == k ? 1 : c[k] - c[q];
            }
            scale_[k] = 1 / product;
            inverse_[k] = 1 / c[k];
        }
        solve_dense<s, s>(powers.data(), integrals.data());
        for (int k = 0; k < s * s; ++k) {
            a[k] = integrals[k % s * s + k / s];
            rate[k] = k % (s + 1) == 0;
        }
        auto matrix = a;
        solve_dense<s, s>(matrix.data(), rate.data());
    }

    // The i-th zero from the right of P_s - P_{s-1} (Legendre), by Newton's method; node 0 is x
    // = 1.
    static double node(int i) {
        if (i == 0) return 1;
        double x = std::cos(2 * std::numbers::pi * i / (2 * s - 1));
        for (int iteration = 0; iteration < 100; ++iteration) {
            double p0 = 1, p1 = x, d0 = 0, d1 = 1;
            for (int k = 2; k <= s; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                const double d2 = d0 + (2 * k - 1) * p1;
                p0 = p1;
                p1 = p2;
                d0 = d1;
                d1 = d2;
            }
            const double step = (p1 - p0) / (d1 - d0);
            x -= step;
            if (std::fabs(step) < 1e-16) break;
        }
        return (1 + x) / 2;
    }

    std::array<double, s> scale_, inverse_;  // 1 / prod_j (c_k - c_j), 1 / c_k
};

// The polynomial through a start and its stages, in Newton's form.
template <int s>
class StagePolynomial {
  public:
    // values: at the start, then at the stages.
    explicit StagePolynomial(const double* values) {
        const auto& inverse = inverse_gaps();
        for (int k = 0; k <= s; ++k) d_[k] = values[k];
        for (int m = 1; m <= s; ++m)
            for (int k = s; k >= m; --k) d_[k] = (d_[k] - d_[k - 1]) * inverse[k * (s + 1) + k - m];
    }

    double operator()(double x) const {
        const auto& c = RadauRule<s>::get().c;
        double value = d_[s];
        for (int k = s - 1; k > 0; --k) value = value * (x - c[k - 1]) + d_[k];
        return value * x + d_[0];
    }

    double slope(double x) const {
        const auto& c = RadauRule<s>::get().c;
        double value = d_[s], slope = 0;
        for (int k = s - 1; k > 0; --k) {
            slope = slope * (x - c[k - 1]) + value;
            value = value * (x - c[k - 1]) + d_[k];
        }
        return slope * x + value;
    }

    // Bernstein coefficients on [0, 1]; the values lie between the smallest and the largest one.
    std::array<double, s + 1> bernstein() const {
        const auto& c = RadauRule<s>::get().c;
        std::array<double, s + 1> b{};
        b[0] = d_[s];
        for (int k = s - 1, degree = 1; k >= 0; --k, ++degree) {  // b (x - z_k) + d_k
            const double z = k > 0 ? c[k - 1] : 0;
            for (int i = degree; i >= 0; --i) {
                const double lower = i > 0 ? b[i - 1] * i : 0;
                const double same = i < degree ? b[i] * (degree - i) : 0;
                b[i] = (lower * (1 - z) - same * z) / degree + d_[k];
            }
        }
        return b;
    }

  private:
    // 1 / (z_k - z_j), where z_0 = 0 and z_k is stage k - 1.
    static const std::array<double, (s + 1) * (s + 1)>& inverse_gaps() {
        static const auto table = [] {
            const auto& c = RadauRule<s>::get().c;
            std::array<double, (s + 1) * (s + 1)> inverse{};
            for (int k = 1; k <= s; ++k)
                for (int j = 0; j < k; ++j)
                    inverse[k * (s + 1) + j] = 1 / (c[k - 1] - (j > 0 ? c[j - 1] : 0));
            return inverse;
        }();
        return table;
    }

    double d_[s + 1];  // divided differences
};

// A polynomial on a subinterval of [0, 1], by its Bernstein coefficients b on that interval.
template <int s>
struct BernsteinInterval {
    double start, end;
    std::array<double, s + 1> b;

    // Split at the fraction x (de Casteljau): keep the second part, return the first one.
    BernsteinInterval split(double x) {
        BernsteinInterval first{start, start + (end - start) * x, {}};
        start = first.end;
        for (int k = 0; k <= s; ++k) {
            first.b[k] = b[0];
            for (int i = 0; i + k < s; ++i) b[i] += x * (b[i + 1] - b[i]);
        }
        return first;
    }

    // Find the first part at whose end the polynomial is below `limit`, by halving down to
    // min_width.
    bool first_below(double limit, double min_width, BernsteinInterval& part) const {
        if (*std::min_element(b.begin(), b.end()) >= limit) return false;
        part = *this;
        if (end - start <= min_width) return b[s] < limit;
        BernsteinInterval second = *this;
        return second.split(0.5).first_below(limit, min_width, part) ||
               second.first_below(limit, min_width, part);
    }
};

}  // namespace serpenoid
