// A master on two wires (I²C), by polling, with a limit on every wait.
//
// The Arduino library Wire waits for ever if the bus is stuck, has 160 bytes of buffers and takes
// an interrupt for each byte. Here a byte takes 23 µs at 400 kHz, and no interrupt delays that of
// the serial receiver.
#pragma once

#include <stdint.h>

namespace two_wire {

void begin();
// Write bytes to consecutive registers, the first one at register_address, in one transfer. Return
// whether the device acknowledged every byte, at the first or the second try.
bool write(uint8_t device, uint8_t register_address, const uint8_t* bytes, uint8_t count);
// The value of one register, or -1 if both tries failed.
int16_t read(uint8_t device, uint8_t register_address);

}  // namespace two_wire
