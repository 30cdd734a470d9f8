// What makes the servos' pulses: the Servo library at the board's own pins (library_driver.cpp), or
// a PCA9685 behind two wires (pca9685_driver.cpp), by the build flag SERPENOID_PCA9685.
#pragma once

#include <stdint.h>

#include "gait.h"

namespace servo_driver {

// Once, at a start: no servo gets pulses.
void begin();
uint16_t min_frame_us();
void begin_frames(uint16_t frame_us, uint16_t oscillator_khz);
// Once a pass of the loop.
void service();
// service() has nothing to do: the loop may sleep.
bool quiet();
// Whatever makes the pulses is there; looked at before servos are attached.
bool answers();

void attach(uint8_t joint, int16_t pulse_us);
void detach();
void pulses(const int16_t (&pulse_us)[firmware::kMaxJoints], uint32_t due_us);

}  // namespace servo_driver
