// Packs of two doubles, as every processor has them: arithmetic, choices, sine and cosine.
#pragma once

#include <cmath>
#if !defined(__GNUC__) || defined(SERPENOID_PLAIN_PACKS)
#include "numerics/plain_pack.hpp"
#endif

namespace serpenoid {

constexpr int kPack = 2;
#if defined(__GNUC__) && !defined(SERPENOID_PLAIN_PACKS)
typedef double Pack __attribute__((vector_size(8 * kPack), may_alias));
typedef long long PackBits __attribute__((vector_size(8 * kPack), may_alias));
// Of any two doubles. No function returns a reference to it: Clang would align it as a pack.
typedef Pack Pair __attribute__((aligned(8)));
#else
using Pack = PlainPack<double>;
using PackBits = PlainPack<long long>;
using Pair = Pack;
#endif

inline Pack all(double value) { return Pack{} + value; }

inline Pack choose(PackBits mask, Pack yes, Pack no) {
    return (Pack)((mask & (PackBits)yes) | (~mask & (PackBits)no));
}

inline bool any(PackBits mask) { return (mask[0] | mask[1]) != 0; }

inline Pack& pack_at(double* p) { return *reinterpret_cast<Pack*>(p); }
inline const Pack& pack_at(const double* p) { return *reinterpret_cast<const Pack*>(p); }

inline void sincos(double x, double& sine, double& cosine) {
    sine = std::sin(x);
    cosine = std::cos(x);
}

// Sine and cosine, to 2.5 units in the last place (1.7 for |x| <= 100).
//
// x = q pi/2 + r with |r| <= pi/4; pi/2 in three parts, the first two of 33 bits, so that q times
// them is exact for |q| < 2^20. On r the polynomials of least relative error (by Remez, 3.6e-18 and
// 5.6e-20 before rounding): sin r = r + r^3 P(r^2), cos r = 1 - r^2/2 + r^4 Q(r^2). Lanes beyond
// 1e6 take the library's functions.
inline void sincos(Pack x, Pack& sine, Pack& cosine) {
    constexpr double kFar = 1e6;
    const Pack round = all(0x1.8p52);  // adding it leaves a whole number
    const Pack shifted = x * 0x1.45f306dc9c883p-1 + round, q = shifted - round;
    Pack r = x - q * 0x1.921fb544p+0;
    r -= q * 0x1.0b4611a6p-34;
    r -= q * 0x1.3198a2e037073p-69;
    const Pack z = r * r;
    const auto polynomial = [&z](const double (&c)[6]) {
        Pack sum = all(c[0]);
        for (int k = 1; k < 6; ++k) sum = sum * z + c[k];
        return sum;
    };
    const Pack P =
        polynomial({0x1.5d8fa31eaaaf9p-33, -0x1.ae5e59f595799p-26, 0x1.71de3567125ecp-19,
                    -0x1.a01a019bfd181p-13, 0x1.111111110f7cap-7, -0x1.5555555555548p-3});
    const Pack Q =
        polynomial({-0x1.8fa465e50a7a6p-37, 0x1.1ee9d7527e435p-29, -0x1.27e4f7ea37780p-22,
                    0x1.a01a019c8390dp-16, -0x1.6c16c16c14f8ap-10, 0x1.555555555554bp-5});
    const Pack s = r + z * r * P, c = 1 - 0.5 * z + z * z * Q;
    const PackBits quadrant = (PackBits)shifted, odd = -(quadrant & 1);
    sine = (Pack)((PackBits)choose(odd, c, s) ^ ((quadrant & 2) << 62));
    cosine = (Pack)((PackBits)choose(odd, s, c) ^ (((quadrant + 1) & 2) << 62));
    if (any((x > kFar) | (-x > kFar))) [[unlikely]]
        for (int j = 0; j < kPack; ++j)
            if (std::fabs(x[j]) > kFar) {
                sine[j] = std::sin(x[j]);
                cosine[j] = std::cos(x[j]);
            }
}

}  // namespace serpenoid
