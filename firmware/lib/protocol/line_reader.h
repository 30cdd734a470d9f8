// Bytes in, whole lines out; says which lines cannot be lines.
#pragma once

#include <stdint.h>

#include "gait.h"

namespace firmware {

// Room for a pose with all its decimals.
constexpr uint8_t line_capacity(uint8_t joints) {
    return static_cast<uint8_t>(joints <= 5 ? 80 : 20 + 12 * joints);
}

class LineReader {
  public:
    enum Event : uint8_t { kNothing, kLine, kOverlong, kGarbled };

    LineReader() : line_(), length_(0), fault_(kNothing) {}

    // One byte more. Anything but kNothing ends a line: read it, then clear().
    Event push(uint8_t byte);
    void clear();

    const char* data() const { return line_; }
    uint8_t length() const { return length_; }

  private:
    char line_[line_capacity(kMaxJoints)];
    uint8_t length_;
    Event fault_;
};

}  // namespace firmware
