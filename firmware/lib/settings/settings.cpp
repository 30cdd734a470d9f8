// From the wire's units to those of the per-frame code, done when a setting changes.
#include "settings.h"

namespace firmware {

void set_defaults(Settings& settings) {
    for (uint8_t i = 0; i < kSettingCount; ++i) settings.value_u[i] = setting_field(i).default_u;
    for (uint8_t f = 0; f < kTrimFieldCount; ++f) {
        const int32_t value_u = trim_field(f).default_u;
        for (uint8_t i = 0; i < kJoints; ++i) settings.trim_u[i][f] = value_u;
    }
}

Trim trim_of(const Settings& settings, uint8_t joint) {
    const int32_t* u = settings.trim_u[joint];
    Trim trim;
    trim.centre_us = static_cast<int16_t>(u[kCentre] / 1000000);
    // 1/32 µs/rad is 31250 millionths.
    trim.scale_q5_us_per_rad = static_cast<uint16_t>((u[kScale] + 15625) / 31250);
    trim.direction = u[kDir] < 0 ? -1 : 1;
    trim.low_q14 = q14_from_q30(q30_from_udeg(u[kLow]));
    trim.high_q14 = q14_from_q30(q30_from_udeg(u[kHigh]));
    return trim;
}

MotionLimits limits_of(const Settings& settings) {
    const int32_t* u = settings.value_u;
    MotionLimits limits;
    limits.angle_step_q30 = q30_from_udeg(u[kAngleRamp] / kFramesPerSecond);
    limits.beta_step_q31_turn = q31_turn_from_udeg(u[kAngleRamp] / kFramesPerSecond);
    limits.rate_step = phase_step(u[kRateRamp] / kFramesPerSecond);
    limits.pose_step_q30 = q30_from_udeg(u[kPoseSpeed] / kFramesPerSecond);
    limits.servo_step_q14 = q14_from_q30(q30_from_udeg(u[kServoSpeed] / kFramesPerSecond));
    for (uint8_t i = 0; i < kJoints; ++i) {
        const Trim trim = trim_of(settings, i);
        limits.low_q14[i] = trim.low_q14;
        limits.high_q14[i] = trim.high_q14;
    }
    return limits;
}

int32_t pulse_at(const Settings& settings, uint8_t joint, TrimField limit) {
    const Trim trim = trim_of(settings, joint);
    return pulse_us(trim, limit == kLow ? trim.low_q14 : trim.high_q14);
}

}  // namespace firmware
