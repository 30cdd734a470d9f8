// Interface to the source of the servos' pulses: the Servo library at the board's own pins
// (library_driver.cpp) or, with the build flag SERPENOID_PCA9685, a PCA9685 chip on the I²C bus
// (pca9685_driver.cpp).
#pragma once

#include <stdint.h>

#include "gait.h"

namespace servo_driver {

// Set up pins and bus, once after a reset. No servo gets pulses yet.
void begin();
// The shortest frame in which all pulses can be made, µs.
uint16_t min_frame_us();
// Set the length of a frame. Only the PCA9685 uses the frequency of its oscillator.
void begin_frames(uint16_t frame_us, uint16_t oscillator_khz);
// Do pending work; called in every pass of the main loop.
void service();
// Whether service() has nothing to do, so that the processor may sleep.
bool quiet();
// Whether the source of pulses responds; checked before servos are attached.
bool answers();

// Begin the pulses of one joint, the first one of this width.
void attach(uint8_t joint, int16_t pulse_us);
// End the pulses of all joints.
void detach();
// Set the pulses of the frame that is due at due_us; 0 for a joint without pulses.
void pulses(const int16_t (&pulse_us)[firmware::kMaxJoints], uint32_t due_us);

}  // namespace servo_driver
