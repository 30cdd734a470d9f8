// CRC-16/IBM-3740: polynomial 0x1021, start 0xFFFF, nothing reflected, check value 29B1.
#pragma once

#include <stdint.h>

namespace firmware {

const uint16_t kCrcStart = 0xFFFF;

// One byte more. The eight shifts of the textbook, folded, in halves of 8 bits: an AVR has no more.
inline uint16_t crc16_next(uint16_t crc, uint8_t byte) {
    uint8_t x = static_cast<uint8_t>((crc >> 8) ^ byte);
    x = static_cast<uint8_t>(x ^ (x >> 4));
    const uint8_t high = static_cast<uint8_t>(crc ^ static_cast<uint8_t>(x << 4) ^ (x >> 3));
    const uint8_t low = static_cast<uint8_t>(x ^ static_cast<uint8_t>(x << 5));
    return static_cast<uint16_t>(high << 8 | low);
}

inline uint16_t crc16(const char* data, uint8_t length) {
    uint16_t crc = kCrcStart;
    while (length--) crc = crc16_next(crc, static_cast<uint8_t>(*data++));
    return crc;
}

}  // namespace firmware
