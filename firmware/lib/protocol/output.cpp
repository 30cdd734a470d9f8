// Decimal digits by subtracting powers of ten: on an AVR that is several times faster than
// dividing.
#include "output.h"

#include "crc16.h"
#include "progmem.h"

namespace firmware {
namespace {

const uint32_t kPowersOfTen[10] FLASH = {1000000000UL, 100000000UL, 10000000UL, 1000000UL, 100000UL,
                                         10000UL,      1000UL,      100UL,      10UL,      1UL};

}  // namespace

uint8_t Output::take() {
    const uint8_t byte = queue_[tail_];
    tail_ = static_cast<uint16_t>((tail_ + 1U) % size());
    return byte;
}

Output& Output::begin() {
    draft_ = head_;
    crc_ = kCrcStart;
    fits_ = true;
    return *this;
}

Output& Output::put(char c) {
    const uint16_t next = static_cast<uint16_t>((draft_ + 1U) % size());
    if (next == tail_) fits_ = false;
    if (!fits_) return *this;
    queue_[draft_] = static_cast<uint8_t>(c);
    crc_ = crc16_next(crc_, static_cast<uint8_t>(c));
    draft_ = next;
    return *this;
}

Output& Output::put(const char* text) {
    while (*text) put(*text++);
    return *this;
}

Output& Output::put_flash(const char* text) {
    for (char c; (c = flash_char(text)) != '\0'; ++text) put(c);
    return *this;
}

void Output::put_digits(uint32_t value, uint8_t decimals) {
    bool started = false;
    for (uint8_t i = value < 100000UL && decimals < 5 ? 5 : 0; i < 10; ++i) {
        const uint32_t power = flash_u32(&kPowersOfTen[i]);
        char digit = '0';
        while (value >= power) {
            value -= power;
            ++digit;
        }
        const uint8_t remaining_digits = static_cast<uint8_t>(9 - i);
        started = started || digit != '0' || remaining_digits <= decimals;
        if (started) put(digit);
        if (remaining_digits == decimals && decimals > 0) put('.');
    }
}

Output& Output::put_unsigned(uint32_t value) {
    put_digits(value, 0);
    return *this;
}

Output& Output::put_fixed(int32_t value, uint8_t decimals) {
    const uint32_t bits = static_cast<uint32_t>(value);
    if (value < 0) put('-');
    put_digits(value < 0 ? 0U - bits : bits, decimals);
    return *this;
}

Output& Output::put_micro(int32_t value_u) {
    uint8_t decimals = 6;
    while (decimals > 0 && value_u % 10 == 0) {
        value_u /= 10;
        --decimals;
    }
    return put_fixed(value_u, decimals);
}

void Output::put_hex16(uint16_t value) {
    for (int8_t shift = 12; shift >= 0; shift = static_cast<int8_t>(shift - 4)) {
        const uint8_t nibble = static_cast<uint8_t>((value >> shift) & 0xF);
        put(static_cast<char>(nibble < 10 ? '0' + nibble : 'A' + nibble - 10));
    }
}

bool Output::finish() {
    const uint16_t crc = crc_;
    put(' ').put('*').put_hex16(crc);
    put('\n');
    if (fits_) head_ = draft_;
    return fits_;
}

}  // namespace firmware
