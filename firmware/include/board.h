// What differs from board to board, and what the wiring fixes.
#pragma once

#include <stdint.h>

namespace board {

#if defined(__AVR_ATmega2560__)
const char kName[] = "mega";
#elif defined(SERPENOID_NANO)
const char kName[] = "nano";
#else
const char kName[] = "uno";
#endif

// Five neighbours in the header of all three boards, clear of the UART (0, 1), of the external
// interrupts (2, 3), of SPI and of the LED. Servo takes timer 1 (Uno, Nano) or 5 (Mega).
const uint8_t kServoPins[5] = {5, 6, 7, 8, 9};  // joint 1, at the tail, to joint 5

// How much longer than asked the servo library's pulses are: it allows for the 328P's digitalWrite.
#if defined(__AVR_ATmega2560__)
const uint8_t kPulseExcessUs = 2;
#else
const uint8_t kPulseExcessUs = 0;
#endif

// Exact at 16 MHz; see PROTOCOL.md.
const uint32_t kBaud = 250000;

}  // namespace board
