// The timer of the Servo library, as far as a frame must know it: where a refresh is, and when the
// next one begins.
//
// The library (1.2 and 1.3 alike) makes the pulses one after the other, each ended by a compare of
// its 16-bit timer at 0.5 µs a tick, then waits until the timer reads 20 ms and sets it back to 0.
// That takes 20003.4 µs, and would drift through the frames. In the gap after the last pulse, and
// only there, the compare register holds 20 ms: then the pulses of the next refresh can be handed
// over together, and the timer can be set so that the refresh begins when it should.
#pragma once

#include <stdint.h>

namespace servo_timer {

// Once: how long a frame is.
void begin(uint16_t frame_us);
// Ticks until the next refresh begins, or 0 while pulses are being made.
uint16_t gap_ticks();
// In the gap: let the next refresh begin so many ticks from now.
void begin_in(uint16_t ticks);
// More than seven joints need a refresh longer than the library's: draws one pulse's slot out of
// the library's count, once a refresh, without touching the pulse itself.
void stretch();

}  // namespace servo_timer
