// What the controller needs from a board: a clock, a byte stream, five servos, EEPROM.
//
// On the board it is src/arduino_hardware.*, in Python a virtual board, in tests a recording one.
#pragma once

#include <stdint.h>

#include "eeprom.h"
#include "gait.h"

namespace firmware {

class Hardware : public Eeprom {
  public:
    // Microseconds since some moment; wraps.
    virtual uint32_t micros() = 0;

    // The next received byte, or -1.
    virtual int16_t receive() = 0;
    // How often the receive buffer was found full, so that bytes may have been lost.
    virtual uint16_t receive_overflows() = 0;
    // Bytes that transmit() takes without waiting.
    virtual uint16_t room() = 0;
    virtual void transmit(const char* text, uint8_t length) = 0;

    // Begin to send these pulses; no pulse of another width goes out first.
    virtual void attach(const int16_t (&pulse_us)[kJoints]) = 0;
    // Let go: no pulse is cut short, then the pins stay low.
    virtual void detach() = 0;
    virtual void pulse(uint8_t joint, int16_t pulse_us) = 0;

    // Bytes between heap and stack that were never used; 0 where nobody counts.
    virtual uint16_t unused_ram() = 0;

  protected:
    ~Hardware() {}
};

}  // namespace firmware
