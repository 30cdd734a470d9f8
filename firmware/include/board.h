// What differs from board to board, and what the wiring fixes.
#pragma once

#include <Arduino.h>
#include <stdint.h>

#include "gait.h"

namespace board {

#if defined(__AVR_ATmega2560__)
const char kName[] = "mega";
#elif defined(SERPENOID_NANO_OLD)
const char kName[] = "nano_old";
#elif defined(SERPENOID_NANO)
const char kName[] = "nano";
#else
const char kName[] = "uno";
#endif

// Neighbours in the header of all three boards, clear of the UART (0, 1), of the external
// interrupts (2, 3) and of the LED. Servo takes timer 1 (Uno, Nano) or 5 (Mega).
const uint8_t kPins[] PROGMEM = {5, 6, 7, 8, 9, 10, 11, 12, A0, A1, A2, A3};
static_assert(firmware::joint_count <= sizeof kPins, "name a pin for each joint");
#ifndef __AVR_ATmega2560__
static_assert(firmware::joint_count <= 8,
              "a Uno or Nano has RAM for 8 joints at most: take a Mega");
#endif

// Of joint 1, at the tail, and so on.
inline uint8_t servo_pin(uint8_t joint) { return pgm_read_byte(&kPins[joint]); }

// Enables the outputs of a PCA9685 while it is low.
const uint8_t kEnablePin = 4;

// How much longer than asked the servo library's pulses are: it allows for the 328P's digitalWrite.
#if defined(__AVR_ATmega2560__)
const uint8_t kPulseExcessUs = 2;
#else
const uint8_t kPulseExcessUs = 0;
#endif

// Exact at 16 MHz; see PROTOCOL.md.
const uint32_t kBaud = 250000;

// A bootloader that leaves the watchdog on after a reset by it would hang for good.
#ifdef SERPENOID_NO_WATCHDOG
const bool kWatchdog = false;
#else
const bool kWatchdog = true;
#endif

}  // namespace board
