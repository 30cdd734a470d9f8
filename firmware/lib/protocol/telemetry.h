// One frame as a line: `t:1234 j1:10.00 ... *A3F1` (see PROTOCOL.md for fields and units).
#pragma once

#include <stdint.h>

#include "gait.h"
#include "text.h"

namespace firmware {

struct Frame {
    uint32_t number;
    uint32_t start_us;
    uint32_t phase;  // 2⁻³² turns
    int16_t setpoint_q14[kJoints];
    int16_t pulse_us[kJoints];  // 0 while detached
    uint32_t run_us;
    uint32_t late_us;
    const char* state;  // in flash
};

void write_telemetry(Text& line, const Frame& frame);

}  // namespace firmware
