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
    int32_t trim_u[kMaxJoints][kTrimFieldCount];
};

// In place: a copy would be the largest thing on the stack.
void set_defaults(Settings& settings);

// One servo's trim in the units of the per-frame code, from its fields on the wire.
Trim trim_of(const int32_t (&trim_u)[kTrimFieldCount]);

// All ramps and limits, in place; `frame_us` is given.
void set_limits(MotionLimits& limits, const Settings& settings);

// The pulse a joint's limit leads to, in µs.
int32_t pulse_at(const int32_t (&trim_u)[kTrimFieldCount], TrimField limit);

// Pulses that the servos may ever be sent.
const int16_t kMinPulseUs = 500;
const int16_t kMaxPulseUs = 2500;

// Whether both limits of a joint can be reached by such a pulse; `beyond_us` is one that cannot.
bool within_pulses(const int32_t (&trim_u)[kTrimFieldCount], int32_t& beyond_us);

}  // namespace firmware
