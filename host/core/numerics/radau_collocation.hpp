// Radau IIA collocation on [0, 1]: nodes, integration matrix, and what dense output needs.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "numerics/dense.hpp"
#include "numerics/gauss_rule.hpp"

namespace serpenoid {

// s stages, the last at the end: order 2s - 1 there, L-stable.
//
// Between the ends, u (the polynomial of degree s through the start and the stages) has the rate
// of the system at the stages but not at the start: with the defect delta = u'(0) - f(0) its error
// is, to leading order, h delta bump(x), bump(x) = integral of prod (1 - x/c_k) from 0 to x.
// Subtracting it gains an order, and its size is an error estimate. bump vanishes at 1.
template <int s>
struct RadauRule {
    std::array<double, s> c;
    std::array<double, s * s> a;  // a[j*s + k] = integral of the k-th Lagrange polynomial, 0..c_j
    std::array<double, s * s> rate;     // u'(c_j) = sum rate_jk (Y_k - y_0): the inverse of a
    std::array<double, s> at0;          // those polynomials at 0
    double bump_height;                 // largest |bump|
    std::array<double, s> dense_scale;  // 1 / (c_k prod_j (c_k - c_j))

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
        for (int k = 0; k < s; ++k) {
            w[k] = dense_scale[k] * x;
            for (int j = 0; j < s; ++j)
                if (j != k) w[k] *= x - c[j];
        }
        return w;
    }

  private:
    RadauRule() {
        const Gauss<s>& gauss = Gauss<s>::get();
        for (int k = 0; k < s; ++k) c[k] = node(s - 1 - k);
        for (int k = 0; k < s; ++k) {
            double product = c[k];
            for (int j = 0; j < s; ++j) product *= j == k ? 1 : c[k] - c[j];
            dense_scale[k] = 1 / product;
            at0[k] = lagrange(k, 0);
            for (int j = 0; j < s; ++j) {
                a[j * s + k] = 0;
                for (int q = 0; q < s; ++q)
                    a[j * s + k] += c[j] * gauss.b[q] * lagrange(k, c[j] * gauss.c[q]);
            }
        }
        auto of_rates = a;
        for (int k = 0; k < s * s; ++k) rate[k] = k % (s + 1) == 0;
        solve_dense<s, s>(of_rates.data(), rate.data());
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
        double x = std::cos(2 * std::numbers::pi * i / (2 * s - 1));
        for (int iteration = 0; iteration < 100; ++iteration) {
            double p0 = 1, p1 = x, d0 = 0, d1 = 1;
            for (int k = 2; k <= s; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k,
                             d2 = d0 + (2 * k - 1) * p1;
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
};

// The polynomial through a start and its stages, in Newton's form.
template <int s>
class StagePolynomial {
  public:
    explicit StagePolynomial(const double* values) {  // the start's and the stages'
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

    // Bernstein's coefficients on [0, 1]: between the least and the largest lie all its values.
    std::array<double, s + 1> bernstein() const {
        const auto& c = RadauRule<s>::get().c;
        std::array<double, s + 1> b{};
        b[0] = d_[s];
        for (int k = s - 1, degree = 1; k >= 0; --k, ++degree) {  // times (x - z_k), and d_k more
            const double z = k > 0 ? c[k - 1] : 0;
            for (int i = degree; i >= 0; --i) {
                const double raised = i > 0 ? b[i - 1] * i : 0;
                const double keep = i < degree ? b[i] * (degree - i) : 0;
                b[i] = (raised * (1 - z) - keep * z) / degree + d_[k];
            }
        }
        return b;
    }

  private:
    // 1 / (z_k - z_j), z being 0 and the stages.
    static const std::array<double, (s + 1) * (s + 1)>& inverse_gaps() {
        static const auto table = [] {
            const auto& c = RadauRule<s>::get().c;
            std::array<double, (s + 1) * (s + 1)> t{};
            for (int k = 1; k <= s; ++k)
                for (int j = 0; j < k; ++j)
                    t[k * (s + 1) + j] = 1 / (c[k - 1] - (j > 0 ? c[j - 1] : 0));
            return t;
        }();
        return table;
    }

    double d_[s + 1];
};

// A polynomial on a stretch of [0, 1], by Bernstein's coefficients there.
template <int s>
struct Stretch {
    double start, end;
    std::array<double, s + 1> b;

    // Cut at the fraction x: keep the second part, return the first one.
    Stretch cut(double x) {
        Stretch first{start, start + (end - start) * x, {}};
        start = first.end;
        for (int k = 0; k <= s; ++k) {
            first.b[k] = b[0];
            for (int i = 0; i + k < s; ++i) b[i] += x * (b[i + 1] - b[i]);
        }
        return first;
    }

    // The first stretch at whose end it is below `limit`, by halving; `shortest` bounds the search.
    bool first_below(double limit, double shortest, Stretch& part) const {
        if (*std::min_element(b.begin(), b.end()) >= limit) return false;
        part = *this;
        if (end - start <= shortest) return b[s] < limit;
        Stretch second = *this;
        return second.cut(0.5).first_below(limit, shortest, part) ||
               second.first_below(limit, shortest, part);
    }
};

}  // namespace serpenoid
