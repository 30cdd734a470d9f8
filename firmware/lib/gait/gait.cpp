// Conversions of angles, and the gait's angle. They multiply and shift, as the AVR cannot divide.
#include "gait.h"

#include "sine.h"

namespace firmware {
namespace {

// value * factor / 2^shift, rounded to nearest.
int32_t scaled(int32_t value, int32_t factor, uint8_t shift) {
    const int64_t product = static_cast<int64_t>(value) * factor;
    return static_cast<int32_t>((product + (static_cast<int64_t>(1) << (shift - 1))) >> shift);
}

}  // namespace

int32_t q30_from_udeg(int32_t angle_udeg) {
    return scaled(angle_udeg, 1257642267L, 26);  // 2³⁰ π/180e6 = 18.74, times 2²⁶
}

int32_t q31_turn_from_udeg(int32_t angle_udeg) {
    return scaled(angle_udeg, 1601279868L, 28);  // 2³¹/360e6 = 5.965, times 2²⁸
}

int16_t cdeg_from_q14(int16_t angle_q14) {
    const int32_t product = angle_q14 * 45837L;  // 18000/(π 2¹⁴) = 0.34971, times 2¹⁷
    return static_cast<int16_t>((product + (1L << 16)) >> 17);
}

uint32_t mdeg_from_phase(uint32_t phase) {
    return static_cast<uint32_t>((static_cast<uint64_t>(phase) * 360000UL) >> 32);
}

// The phase in a frame of 1 µs at 1e-6 rad/s is 2⁶⁴ · 1e-12 / 2π = 2935890.50328.
uint64_t phase_step(int32_t omega_urad_s, uint16_t frame_us) {
    const uint16_t remainder = static_cast<uint16_t>((32983UL * frame_us + 0x8000UL) >> 16);
    const uint64_t per_urad_s = static_cast<uint64_t>(2935890UL) * frame_us + remainder;
    return static_cast<uint64_t>(omega_urad_s) * per_urad_s;
}

int16_t gait_angle(int16_t alpha_q14, int32_t beta_q31_turn, uint32_t phase, uint8_t joint) {
    const uint32_t lag = (static_cast<uint32_t>(beta_q31_turn) << 1) * joint;
    const int32_t product = static_cast<int32_t>(alpha_q14) * sine_q15(phase + lag);
    return static_cast<int16_t>((product + 0x4000L) >> 15);
}

}  // namespace firmware
