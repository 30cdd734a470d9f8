// The numbers in commands: name, unit, limits and default. Suffix _u: in millionths of the unit.
#pragma once

#include <stdint.h>

namespace firmware {

struct Field {
    char name[12];
    char unit[8];
    int32_t low_u, high_u, default_u;
    bool is_integer;  // no decimals
};

// The order of each enum is the order of its table.
enum Setting : uint8_t {
    kAngleRamp,
    kRateRamp,
    kPoseSpeed,
    kServoSpeed,
    kSilence,
    kEvery,
    kLimp,
    kFrame,
    kOscillator,
    kReleased,  // stored for the host: what its user saw the servos do without pulses
    kSettingCount
};
enum TrimField : uint8_t { kCentre, kScale, kDir, kLow, kHigh, kTrimFieldCount };
enum GaitField : uint8_t { kAlpha, kBeta, kOmega, kOffset, kGaitFieldCount };

// Copies from flash.
Field setting_field(uint8_t index);
Field trim_field(uint8_t index);
Field gait_field(uint8_t index);
Field joint_angle_field();

// Whether a setting may also be `off`, or 0, which is outside its range.
inline bool may_be_off(uint8_t setting) { return setting == kSilence || setting == kLimp; }

// Whether a value is within the limits of its field, or is `off` and may be.
bool in_range(const Field& field, int32_t value_u);

}  // namespace firmware
