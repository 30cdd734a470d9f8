// One frame as a line: `t:1234 j1:10.00 ... *A3F1` (see PROTOCOL.md for fields and units).
#pragma once

#include <stdint.h>

#include "gait.h"
#include "output.h"

namespace firmware {

struct Frame {
    uint32_t number;
    uint32_t board_us;  // at its start
    uint32_t phase;     // 2⁻³² turns
    int16_t setpoint_q14[kMaxJoints];
    int16_t pulse_us[kMaxJoints];  // 0 while detached
    uint32_t exec_us;              // from its start until the pulses were handed over
    uint32_t late_us;              // from its due time to its start
    uint8_t clipped;               // joints held back
    const char* state;             // in flash
};

#ifdef SERPENOID_SENSOR
int16_t own_sensor();               // see firmware/src/own_sensor.cpp
const uint8_t kOwnSensorRoom = 14;  // bytes of ` sensor=-32768`
#else
const uint8_t kOwnSensorRoom = 0;
#endif

// False if the line did not fit.
bool write_telemetry(Output& line, const Frame& frame);

}  // namespace firmware
