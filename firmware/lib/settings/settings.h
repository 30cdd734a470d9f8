// The owner's settings: motion settings and the trim of each servo, in the units of the protocol.
#pragma once

#include <stdint.h>

#include "fields.h"
#include "gait.h"
#include "motion.h"
#include "pulse.h"

namespace firmware {

// A plain block of int32, saved to EEPROM byte by byte; all boards are little-endian AVRs.
struct Settings {
    int32_t value_u[kSettingCount];
    int32_t trim_u[kMaxJoints][kTrimFieldCount];
};

// In place, because a copy would need most of the stack.
void set_defaults(Settings& settings);

// The trim of a servo in the units of pulse_us (pulse.h), from its protocol fields.
Trim trim_of(const int32_t (&trim_u)[kTrimFieldCount]);

// Set all ramps and limits in place, except `frame_us`, which they depend on.
void set_limits(MotionLimits& limits, const Settings& settings);

// The pulse at one limit of a joint, µs.
int32_t pulse_at(const int32_t (&trim_u)[kTrimFieldCount], TrimField limit);

// Limits of any pulse, µs.
const int16_t kMinPulseUs = 500;
const int16_t kMaxPulseUs = 2500;

// Whether the pulses at both limits of a joint are allowed; limit_us is one that is not.
bool within_pulses(const int32_t (&trim_u)[kTrimFieldCount], int32_t& limit_us);

}  // namespace firmware
