// A master on two wires (I²C), by polling, with a limit on every wait.
//
// The Wire library waits for ever if the bus is stuck, keeps 160 bytes of buffers and interrupts
// each byte; here a byte takes 23 µs at 400 kHz, and interrupts stay free for the receiver.
#pragma once

#include <stdint.h>

namespace two_wire {

void begin();
// Write bytes to registers from `first` on, in one go. False if some byte was twice not
// acknowledged.
bool write(uint8_t device, uint8_t first, const uint8_t* bytes, uint8_t count);
// Read one register, or -1.
int16_t read(uint8_t device, uint8_t first);

}  // namespace two_wire
