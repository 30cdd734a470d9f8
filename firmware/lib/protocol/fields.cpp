// The tables of fields in PROTOCOL.md; a test compares both.
#include "fields.h"

#include <string.h>

#include "progmem.h"

namespace firmware {
namespace {

// Millionths of the unit.
constexpr int32_t u(double value) {
    return static_cast<int32_t>(value * 1e6 + (value < 0 ? -0.5 : 0.5));
}

// Columns: name, unit, lowest and highest value, default, whether only integers are allowed. A
// default of 0 outside the range is `off`.
const Field kSettingFields[kSettingCount] FLASH = {
    {"angle_ramp", "deg/s", u(1), u(360), u(60), false},
    {"rate_ramp", "rad/s2", u(0.1), u(100), u(5), false},
    {"pose_speed", "deg/s", u(1), u(360), u(45), false},
    {"servo_speed", "deg/s", u(10), u(1000), u(500), false},
    {"silence", "s", u(0.1), u(600), u(2), false},
    {"every", "frames", u(0), u(1000), u(1), true},
    {"limp", "s", u(1), u(2000), u(0), false},
    {"frame_ms", "ms", u(3), u(32.5), u(20), false},
    {"oscillator", "MHz", u(22), u(28), u(25), false},
    {"released", "code", u(0), u(2), u(0), true},
};

const Field kTrimFields[kTrimFieldCount] FLASH = {
    {"centre", "us", u(1000), u(2000), u(1500), true},
    {"scale", "us/rad", u(300), u(1200), u(573), false},
    {"dir", "", u(-1), u(1), u(1), true},
    {"low", "deg", u(-114), u(0), u(-90), false},
    {"high", "deg", u(0), u(114), u(90), false},
};

const Field kGaitFields[kGaitFieldCount] FLASH = {
    {"alpha", "deg", u(0), u(90), u(0), false},
    {"beta", "deg", u(-180), u(180), u(0), false},
    {"omega", "rad/s", u(0.01), u(30), u(0.01), false},
    {"offset", "deg", u(-90), u(90), u(0), false},
};

const Field kJointAngle FLASH = {"angle", "deg", u(-114), u(114), u(0), false};

Field copy_from_flash(const Field* field) {
    Field copy;
#ifdef __AVR__
    memcpy_P(&copy, field, sizeof copy);
#else
    memcpy(&copy, field, sizeof copy);
#endif
    return copy;
}

}  // namespace

Field setting_field(uint8_t index) { return copy_from_flash(&kSettingFields[index]); }
Field trim_field(uint8_t index) { return copy_from_flash(&kTrimFields[index]); }
Field gait_field(uint8_t index) { return copy_from_flash(&kGaitFields[index]); }
Field joint_angle_field() { return copy_from_flash(&kJointAngle); }

bool in_range(const Field& field, int32_t value_u) {
    const bool accepts_off = strcmp(field.name, "silence") == 0 || strcmp(field.name, "limp") == 0;
    if (value_u == 0 && accepts_off) return true;
    if (value_u == 0 && strcmp(field.name, "dir") == 0) return false;
    return value_u >= field.low_u && value_u <= field.high_u;
}

}  // namespace firmware
