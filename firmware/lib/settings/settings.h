// What the owner of a robot sets: motion settings and the trim of each servo, in the wire's units.
#pragma once

#include <stdint.h>

#include "fields.h"
#include "gait.h"
#include "motion.h"
#include "pulse.h"

namespace firmware {

// A plain block of int32: it goes to EEPROM as it is (both ends are little-endian AVRs).
struct Settings {
    int32_t value_u[kSettingCount];
    int32_t trim_u[kJoints][kTrimFieldCount];
};

// In place: a copy would be the largest thing on the stack.
void set_defaults(Settings& settings);

// One servo's trim in the units of the per-frame code.
Trim trim_of(const Settings& settings, uint8_t joint);

// All ramps and limits per frame.
MotionLimits limits_of(const Settings& settings);

// The pulse a joint's limit leads to, for the check that servos can follow; in µs.
int32_t pulse_at(const Settings& settings, uint8_t joint, TrimField limit);

// Pulses that the servos may ever be sent.
const int16_t kLeastPulseUs = 500;
const int16_t kMostPulseUs = 2500;

}  // namespace firmware
