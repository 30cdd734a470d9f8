// Multipliers of viscous_decay.hpp.
#include "periodic/viscous_decay.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/matrix_product.hpp"
#include "periodic/cycle_map.hpp"

namespace serpenoid {

namespace {

constexpr int kStages = ViscousMesh::kStages;
constexpr double kFair = 3;  // largest decay rate times h at which collocation is exact to order 12

// Size of what six-stage Gauss collocation makes of exp(z), z < 0: its Pade approximant.
double gauss_growth(double z) {
    constexpr double c[7] = {1, 1. / 2, 5. / 44, 1. / 66, 1. / 792, 1. / 15840, 1. / 665280};
    double up = c[6], down = c[6];
    for (int k = 5; k >= 0; --k) up = up * z + c[k], down = down * -z + c[k];
    return std::max(std::fabs(up / down), 1e-300);
}

// The sum of the decay rates at a node, times the phase of an element: below 0.
double decay(const ViscousShape& shape, const ViscousMotion& motion, int node) {
    Mat3 A;
    shape.derivative(motion.mesh->nodes[node], motion.stage[node], motion.omega, A);
    return motion.mesh->h * (A[0] + A[4] + A[8]);
}

// By products of exponentials over the mesh. Each factor is accurate to second order in the change
// of the matrix over a piece, at any decay rate. Underflow gives zero.
Slowest by_exponentials(const ViscousShape& shape, const ViscousMotion& motion, int pieces) {
    const ViscousMesh& m = *motion.mesh;
    Mat3 P = identity3();
    double scale = 0;
    for (int e = 0; e < m.elements; ++e)
        for (int k = 0; k < pieces; ++k) {
            const double x = (k + 0.5) / pieces;
            Mat3 A;
            shape.derivative(shape.node((e + x) * m.h), motion.between(e, x), motion.omega, A);
            for (double& a : A) a *= m.h / pieces;
            scale += multiply_exponential(A, P);
        }
    P = mirror_rows(P, shape.mirrored);
    const int halves = shape.mirrored ? 2 : 1;
    const double log_size = halves * (scale + log_spectral_radius(P));
    for (double& v : P) v *= std::exp(scale);
    return {log_size, 0, shape.mirrored ? multiply(P, P) : P};
}

}  // namespace

// Gauss's rule only changes the sign of what decays within an element, from one end to the other.
// The mean of both extrapolations from the stages is then more accurate.
Vec3 state_at_start(const ViscousShape& shape, const ViscousMotion& motion) {
    if (decay(shape, motion, 0) > -kFair) return motion.start;
    Vec3 y = motion.between(0, 0);
    const Vec3 end = motion.between(motion.mesh->elements - 1, 1),
               sign = mirror_signs(shape.mirrored);
    for (int i = 0; i < 3; ++i) y[i] = (y[i] + sign[i] * end[i]) / 2;
    return y;
}

// What decays by more than e^3 or so in an element comes out too large by collocation (by Gauss's
// rule, up to 1), which is harmless while it stays far below the slowest.
Slowest slowest_multiplier(const ViscousShape& shape, const ViscousMotion& motion,
                           const Mat3& monodromy) {
    constexpr int kMostPieces = 64;
    constexpr double kFarBelow = 5;   // of a logarithm
    constexpr double kEnough = 1e-4;  // relative
    const int halves = shape.mirrored ? 2 : 1, elements = motion.mesh->elements;
    const double log_radius = log_spectral_radius(monodromy);
    double spurious = 0, stiffest = 0;
    for (int e = 0; e < elements; ++e) {
        const double z = decay(shape, motion, e * kStages + kStages / 2);
        stiffest = std::min(stiffest, z);
        spurious += halves * std::log(gauss_growth(z));
    }
    const bool none_spurious = stiffest > -kFair || spurious < log_radius - kFarBelow;
    if (-log_radius < kFair * elements * halves && none_spurious) return {log_radius, 0, monodromy};
    Slowest found{}, before = by_exponentials(shape, motion, 2);
    for (int pieces = 4; pieces <= kMostPieces; pieces *= 2) {
        const Slowest next = by_exponentials(shape, motion, pieces);
        const double change = (next.log_size - before.log_size) / 3;
        found = {next.log_size + change, 4 * std::fabs(change), next.monodromy};
        before = next;
        if (std::fabs(change) < kEnough * std::fabs(found.log_size)) break;
    }
    return found;
}

}  // namespace serpenoid
