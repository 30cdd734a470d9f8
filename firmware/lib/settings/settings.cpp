// Conversion from the units of the protocol to those of the frames, once for each change of a
// setting.
#include "settings.h"

namespace firmware {
namespace {

const float kRadPerUdeg = 1.7453293e-8F;

float rad_of(int32_t angle_udeg) { return static_cast<float>(angle_udeg) * kRadPerUdeg; }

}  // namespace

void set_defaults(Settings& settings) {
    for (uint8_t i = 0; i < kSettingCount; ++i) settings.value_u[i] = setting_field(i).default_u;
    for (uint8_t f = 0; f < kTrimFieldCount; ++f) {
        const int32_t value_u = trim_field(f).default_u;
        for (uint8_t i = 0; i < joint_count; ++i) settings.trim_u[i][f] = value_u;
    }
}

Trim trim_of(const int32_t (&u)[kTrimFieldCount]) {
    Trim trim;
    trim.centre_us = static_cast<int16_t>(u[kCentre] / 1000000);
    // One Q5 unit, 1/32 µs/rad, is 31250 millionths.
    trim.scale_q5_us_per_rad = static_cast<uint16_t>((u[kScale] + 15625) / 31250);
    trim.direction = u[kDir] < 0 ? -1 : 1;
    trim.low_q14 = q14_from_q30(q30_from_udeg(u[kLow]));
    trim.high_q14 = q14_from_q30(q30_from_udeg(u[kHigh]));
    return trim;
}

void set_limits(MotionLimits& limits, const Settings& settings) {
    const int32_t* u = settings.value_u;
    limits.change.swing_rad_s = rad_of(u[kAngleRamp]);
    limits.change.rate_rad_s2 = static_cast<float>(u[kRateRamp]) * 1e-6F;
    limits.change.pose_rad_s = rad_of(u[kPoseSpeed]);
    limits.change.servo_rad_s = rad_of(u[kServoSpeed]);
    limits.servo_step_q14 =
        q14_from_q30(q30_from_udeg(per_frame_u(u[kServoSpeed], limits.frame_us)));
    for (uint8_t i = 0; i < joint_count; ++i) {
        limits.low_q14[i] = q14_from_q30(q30_from_udeg(settings.trim_u[i][kLow]));
        limits.high_q14[i] = q14_from_q30(q30_from_udeg(settings.trim_u[i][kHigh]));
    }
}

int32_t pulse_at(const int32_t (&trim_u)[kTrimFieldCount], TrimField limit) {
    const Trim trim = trim_of(trim_u);
    return pulse_us(trim, limit == kLow ? trim.low_q14 : trim.high_q14);
}

bool within_pulses(const int32_t (&trim_u)[kTrimFieldCount], int32_t& limit_us) {
    for (uint8_t f = kLow; f <= kHigh; ++f) {
        limit_us = pulse_at(trim_u, static_cast<TrimField>(f));
        if (limit_us < kMinPulseUs || limit_us > kMaxPulseUs) return false;
    }
    return true;
}

}  // namespace firmware
