// Packs of doubles: arithmetic, sine and cosine.
#pragma once

namespace serpenoid::kernels {
namespace {

template <int W>
struct PackTypes {
    typedef double Real __attribute__((vector_size(8 * W), may_alias));
    typedef long long Bits __attribute__((vector_size(8 * W), may_alias));
};
template <int W>
using Pack = typename PackTypes<W>::Real;
template <class V>
using BitsOf = typename PackTypes<sizeof(V) / 8>::Bits;

template <class V>
inline V all(double value) {
    return V{} + value;
}

// a b + c
template <class V>
inline V fused(V a, V b, V c) {
    return a * b + c;
}

// a b - c, likewise.
template <class V>
inline V fused_less(V a, V b, V c) {
    return a * b - c;
}

template <class V>
inline V choose(BitsOf<V> mask, V yes, V no) {
    return (V)((mask & (BitsOf<V>)yes) | (~mask & (BitsOf<V>)no));
}

template <class V>
inline V square_root(V x) {
    V root;
    for (unsigned j = 0; j < sizeof(V) / 8; ++j) root[j] = __builtin_sqrt(x[j]);
    return root;
}

template <class V>
inline bool any(BitsOf<V> mask) {
    long long bits = 0;
    for (unsigned j = 0; j < sizeof(V) / 8; ++j) bits |= mask[j];
    return bits != 0;
}

// The sum of all lanes, in every lane. Its order depends on the number of lanes only.
template <class V>
inline V total(V x) {
    if constexpr (sizeof(V) == 32) {
        x = x + V{x[2], x[3], x[0], x[1]};
        return x + V{x[1], x[0], x[3], x[2]};
    }
    if constexpr (sizeof(V) == 16) return x + V{x[1], x[0]};
    return x;
}

// Sine and cosine for |x| <= kFar, to 2.5 units in the last place (1.7 for |x| <= 100).
//
// x = q pi/2 + r with |r| <= pi/4; pi/2 in three parts, the first two of 33 bits, so that q times
// them is exact for |q| < 2^20. On r the polynomials of least relative error (by Remez, 3.6e-18 and
// 5.6e-20 before rounding): sin r = r + r^3 P(r^2), cos r = 1 - r^2/2 + r^4 Q(r^2).
constexpr double kFar = 1e6;

template <class V>
[[gnu::always_inline]] inline void sincos_near(V x, V& sine, V& cosine) {
    using B = BitsOf<V>;
    const V round = all<V>(0x1.8p52);  // adding it leaves a whole number
    const V shifted = fused(x, all<V>(0x1.45f306dc9c883p-1), round);
    const V q = shifted - round;
    V r = fused(q, all<V>(-0x1.921fb544p+0), x);
    r = fused(q, all<V>(-0x1.0b4611a6p-34), r);
    r = fused(q, all<V>(-0x1.3198a2e037073p-69), r);
    const V z = r * r;
    V p = all<V>(0x1.5d8fa31eaaaf9p-33);
    p = fused(p, z, all<V>(-0x1.ae5e59f595799p-26));
    p = fused(p, z, all<V>(0x1.71de3567125ecp-19));
    p = fused(p, z, all<V>(-0x1.a01a019bfd181p-13));
    p = fused(p, z, all<V>(0x1.111111110f7cap-7));
    p = fused(p, z, all<V>(-0x1.5555555555548p-3));
    const V s = fused(p, z * r, r);
    V u = all<V>(-0x1.8fa465e50a7a6p-37);
    u = fused(u, z, all<V>(0x1.1ee9d7527e435p-29));
    u = fused(u, z, all<V>(-0x1.27e4f7ea37780p-22));
    u = fused(u, z, all<V>(0x1.a01a019c8390dp-16));
    u = fused(u, z, all<V>(-0x1.6c16c16c14f8ap-10));
    u = fused(u, z, all<V>(0x1.555555555554bp-5));
    const V c = fused(u, z * z, fused(z, all<V>(-0.5), all<V>(1.0)));
    const B quadrant = (B)shifted, odd = -(quadrant & 1);
    sine = (V)((B)choose<V>(odd, c, s) ^ ((quadrant & 2) << 62));
    cosine = (V)((B)choose<V>(odd, s, c) ^ (((quadrant + 1) & 2) << 62));
}

// A function of its own: the rare case costs its callers no registers.
template <class V>
[[gnu::noinline, gnu::cold]] void sincos_far(const V& x, const BitsOf<V>& far, V& sine, V& cosine) {
    for (unsigned j = 0; j < sizeof(V) / 8; ++j)
        if (far[j]) sine[j] = __builtin_sin(x[j]), cosine[j] = __builtin_cos(x[j]);
}

// The same for any x: lanes beyond kFar take the library's functions, the others keep their bits.
template <class V>
[[gnu::always_inline]] inline void sincos(V x, V& sine, V& cosine) {
    sincos_near(x, sine, cosine);
    const BitsOf<V> far = (x > kFar) | (x < -kFar);
    if (__builtin_expect(any<V>(far), 0)) {
        V s = sine, c = cosine;
        sincos_far<V>(x, far, s, c);
        sine = s, cosine = c;
    }
}

}  // namespace
}  // namespace serpenoid::kernels
