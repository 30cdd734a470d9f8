// Queue of received bytes, filled by the receive interrupt, which also detects stops.
//
// Any `!`, and the line end after `stop`, is detected as a stop when it arrives. A stop does not
// wait for the lines before it, and is not lost when the queue is full. A `!` does not enter the
// queue. pop() returns kStopHere at the position of the last stop, so that the reader does not obey
// a command from before the stop.
#pragma once

#include <stdint.h>

#include "gait.h"

namespace firmware {

constexpr uint8_t input_size(uint8_t joints) { return joints <= 7 ? 128 : 192; }

class Input {
  public:
    static const uint8_t kHole = 0;  // takes the place of lost bytes in the queue
    // What pop() returns instead of a byte.
    static const int16_t kNothing = -1, kStopHere = -2;

    constexpr Input()  // constexpr: a static Input costs an AVR no code, as all is 0
        : head_(0),
          tail_(0),
          mark_(0),
          keys_(0),
          words_(0),
          keys_taken_(0),
          words_taken_(0),
          stops_seen_(0),
          progress_(0),
          overflow_count_(0),
          queue_() {}

    // Called by the interrupt for a received byte.
    void push(uint8_t byte);
    // Called by the interrupt when the receiver has lost bytes.
    void lose();

    // The oldest byte in the queue, kStopHere at the position of the last stop, or kNothing.
    int16_t pop();
    // Take one of the stops that await an answer: '!' or, for `stop`, 's'; 0 if there is none.
    char take_stop();
    // Whether the bytes that pop() now returns came before a stop.
    bool before_stop() const { return stops() != stops_seen_; }

    uint16_t overflow_count() const;  // bytes lost because the queue was full

  private:
    void watch(uint8_t byte);
    uint8_t free_places() const;  // in the queue
    void store(uint8_t byte);
    uint8_t stops() const { return static_cast<uint8_t>(keys_ + words_); }

    // Places where the next byte enters and leaves the queue, head_ at the last stop, and the
    // numbers of received `!` and `stop`, modulo 256.
    volatile uint8_t head_, tail_, mark_, keys_, words_;
    uint8_t keys_taken_, words_taken_, stops_seen_;
    volatile uint8_t progress_;  // received letters of `stop`
    volatile uint16_t overflow_count_;
    // The last member: so an AVR reaches the others by a short offset.
    uint8_t queue_[input_size(kMaxJoints)];
};

}  // namespace firmware
