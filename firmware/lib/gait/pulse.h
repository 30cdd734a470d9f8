// From a joint angle to the width of a servo's pulse.
#pragma once

#include <stdint.h>

namespace firmware {

// One servo: how its joint angle becomes a pulse.
struct Trim {
    int16_t centre_us;             // pulse at joint angle 0
    uint16_t scale_q5_us_per_rad;  // in 1/32 µs/rad
    int8_t direction;              // 1, or -1 for a servo mounted the other way round
    int16_t low_q14, high_q14;     // limits of the joint angle, Q14 radians
};

// centre + direction · scale · angle, rounded to 1 µs.
inline int16_t pulse_us(const Trim& trim, int16_t angle_q14) {
    const int32_t product = static_cast<int32_t>(trim.scale_q5_us_per_rad) * angle_q14;
    const int16_t swing_us = static_cast<int16_t>((product + (1L << 18)) >> 19);
    return static_cast<int16_t>(trim.centre_us + trim.direction * swing_us);
}

}  // namespace firmware
