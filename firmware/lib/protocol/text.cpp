// Decimal digits by subtracting powers of ten: on an AVR that is several times faster than
// dividing.
#include "text.h"

#include "crc16.h"
#include "progmem.h"

namespace firmware {
namespace {

const uint32_t kPowersOfTen[10] FLASH = {1000000000UL, 100000000UL, 10000000UL, 1000000UL, 100000UL,
                                         10000UL,      1000UL,      100UL,      10UL,      1UL};

}  // namespace

Text& Text::put(char c) {
    if (length_ < kCapacity) text_[length_++] = c;
    return *this;
}

Text& Text::put(const char* text) {
    while (*text) put(*text++);
    return *this;
}

Text& Text::put_flash(const char* text) {
    for (char c; (c = flash_char(text)) != '\0'; ++text) put(c);
    return *this;
}

void Text::put_digits(uint32_t value, uint8_t decimals) {
    bool started = false;
    for (uint8_t i = 0; i < 10; ++i) {
        const uint32_t power = flash_u32(&kPowersOfTen[i]);
        char digit = '0';
        while (value >= power) {
            value -= power;
            ++digit;
        }
        const uint8_t left = static_cast<uint8_t>(9 - i);  // digits still to come
        started = started || digit != '0' || left <= decimals;
        if (started) put(digit);
        if (left == decimals && decimals > 0) put('.');
    }
}

Text& Text::put_unsigned(uint32_t value) {
    put_digits(value, 0);
    return *this;
}

Text& Text::put_fixed(int32_t value, uint8_t decimals) {
    const uint32_t bits = static_cast<uint32_t>(value);
    if (value < 0) put('-');
    put_digits(value < 0 ? 0U - bits : bits, decimals);
    return *this;
}

Text& Text::put_micro(int32_t value_u) {
    put_fixed(value_u, 6);
    while (text_[length_ - 1] == '0') --length_;
    if (text_[length_ - 1] == '.') --length_;
    return *this;
}

Text& Text::put_hex16(uint16_t value) {
    for (int8_t shift = 12; shift >= 0; shift = static_cast<int8_t>(shift - 4)) {
        const uint8_t nibble = static_cast<uint8_t>((value >> shift) & 0xF);
        put(static_cast<char>(nibble < 10 ? '0' + nibble : 'A' + nibble - 10));
    }
    return *this;
}

Text& Text::finish() {
    const uint16_t crc = crc16(text_, length_);
    return put(' ').put('*').put_hex16(crc).put('\n');
}

}  // namespace firmware
