// Bytes in, whole lines out; says which lines cannot be lines.
#pragma once

#include <stdint.h>

#include "gait.h"

namespace firmware {

class LineReader {
  public:
    // Room for a pose with all its decimals.
    static const uint8_t kCapacity = kJoints <= 5 ? 80 : 20 + 12 * kJoints;
    enum Event : uint8_t { kNothing, kLine, kOverlong, kGarbled };

    LineReader() : line_(), length_(0), fault_(kNothing) {}

    // One byte more. Anything but kNothing ends a line: read it, then clear().
    Event push(uint8_t byte);
    void clear();

    const char* data() const { return line_; }
    uint8_t length() const { return length_; }

  private:
    char line_[kCapacity];
    uint8_t length_;
    Event fault_;
};

}  // namespace firmware
