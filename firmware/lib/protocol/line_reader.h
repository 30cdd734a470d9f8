// Bytes in, whole lines out; says which lines cannot be lines.
#pragma once

#include <stdint.h>

namespace firmware {

class LineReader {
  public:
    static const uint8_t kCapacity = 80;
    enum Event : uint8_t { kNothing, kLine, kOverlong, kGarbled };

    LineReader() : line_(), length_(0), last_(0), fault_(kNothing) {}

    // One byte more. Anything but kNothing ends a line: read it, then clear().
    Event push(uint8_t byte);
    void clear();

    const char* data() const { return line_; }
    uint8_t length() const { return length_; }
    // Something has come since the last line end.
    bool partial() const { return length_ > 0 || fault_ != kNothing; }
    // The last byte was the stop key, whatever came before it.
    bool ends_with_stop_key() const { return last_ == '!'; }

  private:
    char line_[kCapacity];
    uint8_t length_;
    uint8_t last_;
    Event fault_;
};

}  // namespace firmware
