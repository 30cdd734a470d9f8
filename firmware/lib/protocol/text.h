// A line under construction: bounded text in a fixed buffer, numbers without division or floats.
#pragma once

#include <stdint.h>

namespace firmware {

class Text {
  public:
    static const uint8_t kCapacity = 200;

    Text() : text_(), length_(0) {}

    const char* data() const { return text_; }
    uint8_t length() const { return length_; }
    void clear() { length_ = 0; }

    Text& put(char c);
    Text& put(const char* text);
    // Text that lies in flash, ends with NUL.
    Text& put_flash(const char* text);
    Text& put_unsigned(uint32_t value);
    // value · 10^-decimals, with exactly that many decimals (0 to 6).
    Text& put_fixed(int32_t value, uint8_t decimals);
    // Millionths, without the zeros at the end: 1500000 is `1.5`.
    Text& put_micro(int32_t value_u);
    Text& put_hex16(uint16_t value);
    // ` *CRC` over all that is there, and the line end.
    Text& finish();

  private:
    void put_digits(uint32_t value, uint8_t decimals);

    char text_[kCapacity];
    uint8_t length_;
};

}  // namespace firmware
