// What decays fast in viscous.hpp: the slowest multiplier beside it, and the state at phase 0.
#include <algorithm>
#include <cmath>

#include "numerics/matrix_product.hpp"
#include "periodic/viscous.hpp"

namespace serpenoid {

namespace {

// Size of what six-stage Gauss collocation makes of exp(z), z < 0: its Pade approximant.
double gauss_growth(double z) {
    constexpr double c[7] = {1, 1. / 2, 5. / 44, 1. / 66, 1. / 792, 1. / 15840, 1. / 665280};
    double up = c[6], down = c[6];
    for (int k = 5; k >= 0; --k) up = up * z + c[k], down = down * -z + c[k];
    return std::max(std::fabs(up / down), 1e-300);
}

}  // namespace

// The state at phase 0. Where what decays does so within an element, Gauss's rule only turns it
// round at the ends of elements; the stages then know better, from both sides.
Vec3 SteadyViscous::beginning(const Mesh& m, double omega) const {
    constexpr double kFair = 3;
    Mat3 A;
    derivative(m.nodes[0], now_.stage[0], omega, A);
    if (m.h * (A[0] + A[4] + A[8]) > -kFair) return now_.start;
    Vec3 y = between(0, 0);
    const Vec3 end = between(m.elements - 1, 1);
    for (int i = 0; i < 3; ++i) y[i] = (y[i] + (i > 0 && mirrored_ ? -1 : 1) * end[i]) / 2;
    return y;
}

// The state at the fraction x of an element, by its stages.
Vec3 SteadyViscous::between(int e, double x) const {
    const auto weight = Rule::get().lagrange(x);
    Vec3 y{};
    for (int k = 0; k < kStages; ++k)
        for (int i = 0; i < 3; ++i) y[i] += weight[k] * now_.stage[e * kStages + k][i];
    return y;
}

// Logarithm of the largest multiplier over the mesh, by products of exponentials: whatever decays
// however fast, each factor is right to second order in the change of the matrix over a piece.
double SteadyViscous::followed_slowest(const Mesh& m, double omega, int pieces) const {
    Mat3 P = identity3();
    double scale = 0;
    for (int e = 0; e < m.elements; ++e)
        for (int k = 0; k < pieces; ++k) {
            const double x = (k + 0.5) / pieces;
            Mat3 A;
            derivative(node((e + x) * m.h), between(e, x), omega, A);
            for (double& a : A) a *= m.h / pieces;
            scale += multiply_exponential(A, P);
        }
    if (mirrored_)
        for (int r = 3; r < 9; ++r) P[r] = -P[r];
    return (scale + log_spectral_radius(P)) * (mirrored_ ? 2 : 1);
}

// The transfer matrices of collocation are exact to order 12 while a mode decays by less than e^3
// or so in an element. What decays faster comes out too large (by Gauss's rule, up to 1), which is
// harmless while it stays far below the slowest.
void SteadyViscous::slowest(const Mesh& m, double omega, SteadyState& out) const {
    constexpr double kFair = 3;
    const int halves = mirrored_ ? 2 : 1;
    const double log_radius = log_spectral_radius(out.monodromy);
    double false_ones = 0, stiffest = 0;
    for (int e = 0; e < m.elements; ++e) {
        Mat3 A;
        const int middle = e * kStages + kStages / 2;
        derivative(m.nodes[middle], now_.stage[middle], omega, A);
        const double z = m.h * (A[0] + A[4] + A[8]);
        stiffest = std::min(stiffest, z);
        false_ones += halves * std::log(gauss_growth(z));
    }
    out.slowest = log_radius, out.slowest_error = 0;
    const bool none_false = stiffest > -kFair || false_ones < log_radius - 5;
    if (-log_radius < kFair * m.elements * halves && none_false) return;
    double before = followed_slowest(m, omega, 2);
    for (int pieces = 4; pieces <= 64; pieces *= 2) {
        const double next = followed_slowest(m, omega, pieces);
        out.slowest = next + (next - before) / 3;
        const double error = std::fabs(next - before) / 3;
        out.slowest_error = 4 * error;
        before = next;
        if (error < 1e-4 * std::fabs(out.slowest)) break;
    }
}

}  // namespace serpenoid
