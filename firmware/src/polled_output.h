// Serial output without interrupts, so that no servo pulse waits for one.
//
// A transmit interrupt takes 5 µs and at 250000 baud comes every 40: an eighth of all pulse edges
// that fall into a line would be late by up to 8 µs. Here loop() hands over the bytes instead.
#pragma once

#include <stdint.h>

namespace firmware {

class PolledOutput {
  public:
    PolledOutput() : queue_(), head_(0), tail_(0) {}

    // How many bytes write() would take now.
    uint8_t room() const { return static_cast<uint8_t>(tail_ - head_ - 1); }
    bool empty() const { return head_ == tail_; }
    // Queues the whole text, or nothing if there is no room for all of it.
    bool write(const char* text, uint8_t length);
    // Gives the UART its next byte if it wants one. To be called as often as possible.
    void poll();

  private:
    uint8_t queue_[256];   // indices wrap by themselves
    uint8_t head_, tail_;  // next free place, next byte to go
};

}  // namespace firmware
