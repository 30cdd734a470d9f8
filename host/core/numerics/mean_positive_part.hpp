// Mean over an element of the positive part of a product known at the Gauss nodes.
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

    // True only if it has no root in [-1, 1]: the constant outweighs all the rest.
    bool one_sign() const {
        double rest = 0;
        for (int k = 1; k < s; ++k) rest += std::fabs(coefficient_[k]);
        return std::fabs(coefficient_[0]) > rest;
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

// Root of f between a and b, where fa and fb differ in sign (Illinois' regula falsi), to `near` it.
template <class Function>
double bracketed_root(const Function& f, double a, double fa, double b, double fb,
                      double near = 0) {
    const double tiny = std::fmax(near, 1e-14 * (std::fabs(fa) + std::fabs(fb)));
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

// The sign changes of a polynomial on [-1, 1], in order. The search looks between twice as many
// points as nodes, and at the bottom of each dip, where a close pair of roots may be.
template <int s>
class SignChanges {
  public:
    static constexpr int kMost = 2 * s;

    explicit SignChanges(const NodePolynomial<s>& p) : first_(p(-1)) {
        if (p.one_sign()) return;
        const auto& z = points();
        double z0 = z[0], v0 = first_, z1 = z[1], v1 = p(z1);
        for (int k = 2; k <= 2 * s + 2; ++k) {
            const double z2 = z[k], v2 = p(z2);
            dip(p, z0, v0, z1, v1, z2, v2);
            between(p, z0, v0, z1, v1);
            z0 = z1, v0 = v1, z1 = z2, v1 = v2;
        }
        between(p, z0, v0, z1, v1);
    }

    double first() const { return first_; }  // the value at -1
    int count = 0;
    std::array<double, kMost> at;

  private:
    // Ends, nodes and the middles of the gaps.
    static const std::array<double, 2 * s + 3>& points() {
        static const std::array<double, 2 * s + 3> all = [] {
            const Gauss<s>& rule = Gauss<s>::get();
            std::array<double, 2 * s + 3> z{};
            z[0] = -1, z[2 * s + 2] = 1;
            for (int k = 0; k < s; ++k) z[2 * k + 2] = 2 * rule.c[k] - 1;
            for (int k = 1; k < 2 * s + 2; k += 2)
                z[k] = ((k > 1 ? z[k - 1] : -1) + (k < 2 * s ? z[k + 1] : 1)) / 2;
            return z;
        }();
        return all;
    }

    using P = NodePolynomial<s>;
    void between(const P& p, double a, double fa, double b, double fb) {
        if ((fa > 0) != (fb > 0) && count < kMost) at[count++] = bracketed_root(p, a, fa, b, fb);
    }

    // Three values of one sign, the middle one nearest to zero: look at the bottom of the parabola.
    void dip(const P& p, double a, double fa, double& m, double& fm, double b, double fb) {
        if ((fa > 0) != (fm > 0) || (fm > 0) != (fb > 0)) return;
        const double s0 = (fm - fa) / (m - a), s1 = (fb - fm) / (b - m), sign = fm > 0 ? 1 : -1;
        if (sign * s0 >= 0 || sign * s1 <= 0) return;
        const double curvature = (s1 - s0) / (b - a);
        const double z = (a + m) / 2 - s0 / (2 * curvature), v = p(z);
        if (!(z > a && z < b) || (v > 0) == (fm > 0)) return;
        if (z > m) {
            m = z, fm = v;  // the gaps on both sides find their roots
        } else if (count + 2 <= kMost) {
            at[count++] = bracketed_root(p, a, fa, z, v);
            at[count++] = bracketed_root(p, z, v, m, fm);
        }
    }

    double first_;
};

// The positive part of the polynomial through values at the Gauss nodes, on [-1, 1].
template <int s>
class PositivePart {
  public:
    explicit PositivePart(const std::array<double, s>& values)
        : p_(values), changes_(p_), from_(p_.primitive(-1)) {}

    // Its integral from -1 to z.
    double until(double z) const {
        double sum = 0, from = from_;
        bool positive = changes_.first() > 0;
        for (int k = 0; k < changes_.count && changes_.at[k] < z; ++k, positive = !positive) {
            const double to = p_.primitive(changes_.at[k]);
            if (positive) sum += to - from;
            from = to;
        }
        return positive ? sum + p_.primitive(z) - from : sum;
    }

  private:
    NodePolynomial<s> p_;
    SignChanges<s> changes_;
    double from_;
};

// Mean of max(-a b, 0) over an element: both by their values at the nodes. b changes sign once, at
// `turn` (in [-1, 1] or beyond), and has the sign of `before` to the left of it. The polynomial of
// the product is integrated between the sign changes of the factors: in the product a close pair
// would be missed.
template <int s>
double mean_positive_product(const std::array<double, s>& a, const std::array<double, s>& b,
                             double turn, double before) {
    std::array<double, s> product;
    for (int k = 0; k < s; ++k) product[k] = -a[k] * b[k];
    const NodePolynomial<s> p(product), factor(a);
    const SignChanges<s> changes(factor);
    double sign = (changes.first() > 0) == (before > 0) ? -1 : 1, sum = 0;
    if (turn <= -1) sign = -sign, turn = 2;
    double from = p.primitive(-1);
    const auto piece = [&](double z) {
        const double to = p.primitive(z);
        if (sign > 0) sum += to - from;
        from = to, sign = -sign;
    };
    for (int k = 0; k < changes.count; ++k) {
        if (turn < changes.at[k]) piece(turn), turn = 2;
        piece(changes.at[k]);
    }
    if (turn < 1) piece(turn);
    piece(1);
    return sum / 2;
}

}  // namespace serpenoid
