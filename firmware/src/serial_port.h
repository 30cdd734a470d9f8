// The UART: received bytes come by interrupt, bytes to send are handed over by the loop.
//
// A transmit interrupt would come every 40 µs at 250000 baud, and an eighth of all pulse edges that
// fall into a line would be late by up to 8 µs. A receive interrupt is needed: the hardware holds
// three bytes, and a stop must be seen whatever the loop is doing.
#pragma once

#include "hardware.h"

namespace serial_port {

extern firmware::SerialQueues queues;

// 8 bits, no parity, 1 stop bit, at board::kBaud.
void begin();
// Gives the UART its next byte if it wants one. To be called as often as possible.
void poll();

}  // namespace serial_port
