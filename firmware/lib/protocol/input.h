// Bytes on their way in: a queue that the receive interrupt fills, and a watch for stops.
//
// Any `!`, and the line end behind `stop`, is a stop as it arrives: it never waits for a line
// before it, and is never lost because the queue is full. A `!` does not enter the queue. Where
// the last stop stood is told to whoever empties the queue, so that nothing that came before it is
// obeyed after it.
#pragma once

#include <stdint.h>

#include "gait.h"

namespace firmware {

constexpr uint8_t input_size(uint8_t joints) { return joints <= 7 ? 128 : 192; }

class Input {
  public:
    static const uint8_t kHole = 0;  // stands for bytes that were lost
    // What pop() returns instead of a byte.
    static const int16_t kNothing = -1, kStopHere = -2;

    constexpr Input()  // costs an AVR no code: a static one is zero before the program begins
        : head_(0),
          tail_(0),
          mark_(0),
          keys_(0),
          words_(0),
          keys_taken_(0),
          words_taken_(0),
          stops_seen_(0),
          progress_(0),
          full_(0),
          queue_() {}

    // By the interrupt: one byte has come; some were lost before the next one.
    void push(uint8_t byte);
    void lose();

    // The oldest byte; or kStopHere, where the last stop stood; or kNothing.
    int16_t pop();
    // One stop that has not been taken yet: '!', 's' for `stop`, or 0.
    char take_stop();
    // What is popped now came before a stop.
    bool before_stop() const { return stops() != stops_seen_; }

    uint16_t full() const;  // bytes lost as the queue was full

  private:
    void watch(uint8_t byte);
    uint8_t free_places() const;
    void store(uint8_t byte);
    uint8_t stops() const { return static_cast<uint8_t>(keys_ + words_); }

    volatile uint8_t head_, tail_, mark_, keys_, words_;
    uint8_t keys_taken_, words_taken_, stops_seen_;
    volatile uint8_t progress_;  // letters of `stop` that have come
    volatile uint16_t full_;
    uint8_t
        queue_[input_size(kMaxJoints)];  // last, where the rest is reached in fewer steps on an AVR
};

}  // namespace firmware
