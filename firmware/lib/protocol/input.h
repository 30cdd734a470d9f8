// Bytes on their way in: a queue that the receive interrupt fills, and a watch for bare stops.
//
// `!` or `stop`, alone between line ends, is seen as its last byte arrives: a stop never waits for
// a line before it, and is never lost because the queue is full. `mark` is where it stood among
// the bytes, so that nothing that came before a stop is obeyed after it.
#pragma once

#include <stdint.h>

#include "gait.h"

namespace firmware {

class Input {
  public:
    static const uint8_t kSize = kJoints <= 7 ? 128 : 192;
    static const uint8_t kHole = 0;  // stands for bytes that were lost

    Input()
        : head_(0),
          tail_(0),
          mark_(0),
          arrivals_(0),
          keys_(0),
          words_(0),
          keys_taken_(0),
          words_taken_(0),
          last_(0),
          progress_(kStart),
          forget_(false),
          full_(0),
          queue_() {}

    // By the interrupt: one byte has come; some were lost before the next one.
    void push(uint8_t byte);
    void lose();

    // The oldest byte, or -1.
    int16_t pop();
    // One bare stop that has not been taken yet: '!', 's' for `stop`, or 0.
    char take_stop();
    // Whether the bytes up to the last stop, its own line included, have all been popped.
    bool at_mark() const { return tail_ == mark_; }
    // Take what has come so far for a stop: for a key that stands at a pause.
    void mark_here();

    uint8_t arrivals() const { return arrivals_; }  // bytes that have come, modulo 256
    uint8_t last() const { return last_; }          // the last of them
    uint16_t full() const;                          // bytes lost as the queue was full

  private:
    enum Progress : uint8_t { kStart, kKey, kS, kSt, kSto, kStop, kOther };

    void watch(uint8_t byte);
    uint8_t free_places() const;
    void store(uint8_t byte);

    volatile uint8_t head_, tail_, mark_;
    volatile uint8_t arrivals_, keys_, words_;
    uint8_t keys_taken_, words_taken_;
    volatile uint8_t last_, progress_;
    volatile bool forget_;
    volatile uint16_t full_;
    uint8_t queue_[kSize];  // last, where the rest is reached in fewer steps on an AVR
};

}  // namespace firmware
