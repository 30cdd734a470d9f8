// Packs (vectors of two lanes) in standard C++, for compilers without vector types.
//
// A comparison returns a mask: in each of its lanes all bits are set, or none.
#pragma once

#include <bit>

namespace serpenoid {

template <class T>
struct PlainPack {
    T lane[2] = {};

    PlainPack() = default;
    PlainPack(T value) : lane{value, value} {}
    PlainPack(T first, T second) : lane{first, second} {}
    // The same bits as lanes of another type, like a cast between vector types.
    template <class Source>
    explicit PlainPack(const PlainPack<Source>& source)
        : PlainPack(std::bit_cast<PlainPack>(source)) {}

    T& operator[](int i) { return lane[i]; }
    T operator[](int i) const { return lane[i]; }

#define SERPENOID_LANES(operation)                                  \
    friend PlainPack operator operation(PlainPack a, PlainPack b) { \
        return {a[0] operation b[0], a[1] operation b[1]};          \
    }
    SERPENOID_LANES(+)
    SERPENOID_LANES(-)
    SERPENOID_LANES(*)
    SERPENOID_LANES(/)
    SERPENOID_LANES(&)
    SERPENOID_LANES(|)
    SERPENOID_LANES(^)
    SERPENOID_LANES(<<)
#undef SERPENOID_LANES
    friend PlainPack operator~(PlainPack a) { return {~a[0], ~a[1]}; }
    friend PlainPack operator-(PlainPack a) { return {-a[0], -a[1]}; }
    friend PlainPack<long long> operator>(PlainPack a, PlainPack b) {
        return {-(a[0] > b[0]), -(a[1] > b[1])};
    }
    PlainPack& operator+=(PlainPack b) { return *this = *this + b; }
    PlainPack& operator-=(PlainPack b) { return *this = *this - b; }
};

}  // namespace serpenoid
