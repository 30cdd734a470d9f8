// LU of block-tridiagonal matrices, real or complex, with at most one bordering row and column.
//
// Elimination runs block by block without pivoting between blocks: the matrices here are masses
// plus dampers plus springs between neighbours, whose pivots are those of a shorter chain.
#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace serpenoid {

// A complex number whose product is four multiplications (std::complex tests each for infinities).
struct Complex {
    double re = 0, im = 0;
    Complex(double real = 0, double imaginary = 0) : re(real), im(imaginary) {}
    Complex& operator+=(Complex b) { return re += b.re, im += b.im, *this; }
    Complex& operator-=(Complex b) { return re -= b.re, im -= b.im, *this; }
};
inline Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
inline Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
inline Complex operator-(Complex a) { return {-a.re, -a.im}; }
inline Complex operator*(Complex a, Complex b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
inline Complex operator*(double a, Complex b) { return {a * b.re, a * b.im}; }
inline double size(double a) { return std::fabs(a); }
inline double size(Complex a) { return std::sqrt(a.re * a.re + a.im * a.im); }
inline double reciprocal(double a) { return 1 / a; }
inline Complex reciprocal(Complex a) {
    const double f = 1 / (a.re * a.re + a.im * a.im);
    return {a.re * f, -a.im * f};
}

// Square blocks, row by row.
template <int B, class Scalar>
using Block = std::array<Scalar, static_cast<std::size_t>(B* B)>;

template <int B, class Scalar>
Block<B, Scalar> product(const Block<B, Scalar>& a, const Block<B, Scalar>& b) {
    Block<B, Scalar> c{};
    for (int i = 0; i < B; ++i)
        for (int k = 0; k < B; ++k)
            for (int j = 0; j < B; ++j) c[i * B + j] += a[i * B + k] * b[k * B + j];
    return c;
}

// y -= a x
template <int B, class Scalar>
void subtract_product(const Block<B, Scalar>& a, const Scalar* x, Scalar* y) {
    for (int i = 0; i < B; ++i)
        for (int j = 0; j < B; ++j) y[i] -= a[i * B + j] * x[j];
}

template <class Scalar>
std::array<Scalar, 4> inverse(const std::array<Scalar, 4>& a) {
    const Scalar f = reciprocal(a[0] * a[3] - a[1] * a[2]);
    return {f * a[3], -(f * a[1]), -(f * a[2]), f * a[0]};
}

template <class Scalar>
std::array<Scalar, 9> inverse(const std::array<Scalar, 9>& a) {
    const Scalar c0 = a[4] * a[8] - a[5] * a[7], c1 = a[5] * a[6] - a[3] * a[8],
                 c2 = a[3] * a[7] - a[4] * a[6];
    const Scalar f = reciprocal(a[0] * c0 + a[1] * c1 + a[2] * c2);
    return {f * c0, f * (a[2] * a[7] - a[1] * a[8]), f * (a[1] * a[5] - a[2] * a[4]),
            f * c1, f * (a[0] * a[8] - a[2] * a[6]), f * (a[2] * a[3] - a[0] * a[5]),
            f * c2, f * (a[1] * a[6] - a[0] * a[7]), f * (a[0] * a[4] - a[1] * a[3])};
}

// Fill diagonal, lower (left of diagonal i), upper (right of it) and, if bordered, row, column and
// corner; then factor, then solve as often as wanted. Vectors: n blocks of B, then the border's.
template <int B, bool bordered, class Scalar>
class BlockTridiagonal {
  public:
    explicit BlockTridiagonal(int blocks)
        : diagonal(blocks),
          lower(blocks),
          upper(blocks),
          row(bordered ? blocks * B : 0),
          column(bordered ? blocks * B : 0) {}

    // Returns false when a pivot is not a number; the matrix is destroyed.
    bool factor() {
        const std::size_t n = diagonal.size();
        for (std::size_t i = 0;; ++i) {
            diagonal[i] = inverse(diagonal[i]);
            if (!(size(diagonal[i][0]) < kHuge)) return false;
            if (i + 1 == n) break;
            // lower becomes the multiplier, upper what back substitution needs
            lower[i + 1] = product<B>(lower[i + 1], diagonal[i]);
            const Block<B, Scalar> fill = product<B>(lower[i + 1], upper[i]);
            for (int e = 0; e < B * B; ++e) diagonal[i + 1][e] -= fill[e];
            upper[i] = product<B>(diagonal[i], upper[i]);
        }
        if constexpr (bordered) {
            solve_blocks(column.data());
            for (std::size_t i = 0; i < row.size(); ++i) corner -= row[i] * column[i];
            corner = reciprocal(corner);
            return size(corner) < kHuge;
        }
        return true;
    }

    void solve(Scalar* x) const {
        solve_blocks(x);
        if constexpr (bordered) {
            const std::size_t n = row.size();
            Scalar last = x[n];
            for (std::size_t i = 0; i < n; ++i) last -= row[i] * x[i];
            x[n] = last = corner * last;
            for (std::size_t i = 0; i < n; ++i) x[i] -= column[i] * last;
        }
    }

    std::vector<Block<B, Scalar>> diagonal, lower, upper;
    std::vector<Scalar> row, column;
    Scalar corner = 0;

  private:
    static constexpr double kHuge = 1e300;

    void solve_blocks(Scalar* x) const {
        const std::size_t n = diagonal.size();
        for (std::size_t i = 1; i < n; ++i)
            subtract_product<B>(lower[i], x + (i - 1) * B, x + i * B);
        for (std::size_t i = n; i-- > 0;) {
            Scalar y[B];
            for (int b = 0; b < B; ++b) y[b] = 0;
            subtract_product<B>(diagonal[i], x + i * B, y);
            for (int b = 0; b < B; ++b) x[i * B + b] = -y[b];
            if (i + 1 < n) subtract_product<B>(upper[i], x + (i + 1) * B, x + i * B);
        }
    }
};

}  // namespace serpenoid
