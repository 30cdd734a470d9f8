// Lines on their way out: written straight into the queue that the UART empties, with their CRC.
//
// A line is a draft until finish(): one that does not fit is dropped whole. Numbers are written
// without division by variables and without floats.
#pragma once

#include <stdint.h>

#include "gait.h"

namespace firmware {

// The longest telemetry line has 96 bytes and 18 a joint.
constexpr uint16_t output_size(uint8_t joints) { return joints <= 8 ? 256 : 512; }

class Output {
  public:
    static uint16_t size() { return output_size(joint_count); }

    constexpr Output() : head_(0), tail_(0), draft_(0), crc_(0), fits_(false), queue_() {}

    // How long a line may be now.
    uint16_t room() const { return static_cast<uint16_t>((tail_ - head_ - 1U) % size()); }
    bool empty() const { return head_ == tail_; }
    // The next byte to send; only if not empty.
    uint8_t take();

    // Begin a line.
    Output& begin();
    Output& put(char c);
    Output& put(const char* text);
    // Text that lies in flash, ends with NUL.
    Output& put_flash(const char* text);
    Output& put_unsigned(uint32_t value);
    // value · 10^-decimals, with exactly that many decimals (0 to 6).
    Output& put_fixed(int32_t value, uint8_t decimals);
    // Millionths, without the zeros at the end: 1500000 is `1.5`.
    Output& put_micro(int32_t value_u);
    // ` *CRC` over the whole line, and its end; false if it did not fit and has been dropped.
    bool finish();

  private:
    void put_digits(uint32_t value, uint8_t decimals);
    void put_hex16(uint16_t value);

    // The queue comes last: an AVR reaches only the first 64 bytes of an object at once.
    uint16_t head_, tail_, draft_;  // behind the last whole line; next byte to go; next to write
    uint16_t crc_;                  // of the draft
    bool fits_;
    uint8_t queue_[output_size(kMaxJoints)];
};

}  // namespace firmware
