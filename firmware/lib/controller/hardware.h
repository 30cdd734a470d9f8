// What the controller needs from a board: a clock, a wire, servos, EEPROM.
//
// On the board it is src/arduino_hardware.*, in Python a virtual board, in tests a recording one.
#pragma once

#include <stdint.h>

#include "eeprom.h"
#include "gait.h"
#include "input.h"
#include "output.h"

namespace firmware {

// Both queues of the serial port: whoever has the UART fills the one and empties the other.
struct SerialQueues {
    Input input;
    Output output;
};

class Hardware : public Eeprom {
  public:
    // Microseconds since some moment; wraps.
    virtual uint32_t micros() = 0;
    virtual SerialQueues& serial() = 0;

    // What makes the pulses is there; asked before servos are attached, and each frame.
    virtual bool output_answers() { return true; }
    // Begin to send pulses to one servo; none of another width goes out first.
    virtual void attach(uint8_t joint, int16_t pulse_us) = 0;
    // Let go of all: no pulse is cut short, then the pins stay low.
    virtual void detach() = 0;
    // The pulses of the frame that was due at this time, all of them for one refresh.
    virtual void pulses(const int16_t (&pulse_us)[kMaxJoints], uint32_t due_us) = 0;

    // The shortest frame that leaves time for all pulses; at a start, the one that is chosen, and
    // what the clock of a separate servo driver is believed to be.
    virtual uint16_t min_frame_us() const = 0;
    virtual void begin_frames(uint16_t frame_us, uint16_t oscillator_khz) = 0;

    // Bytes between heap and stack that were never used; 0 where nobody counts.
    virtual uint16_t unused_ram() = 0;

  protected:
    ~Hardware() {}
};

}  // namespace firmware
