// CRC-16/IBM-3740: polynomial 0x1021, start 0xFFFF, nothing reflected, check value 29B1.
#pragma once

#include <stdint.h>

namespace firmware {

const uint16_t kCrcStart = 0xFFFF;

// One byte more. The eight shifts of the textbook, folded: 16 bits are too few for a table in RAM.
inline uint16_t crc16_next(uint16_t crc, uint8_t byte) {
    uint16_t x = static_cast<uint16_t>(static_cast<uint16_t>(crc << 8) | (crc >> 8));
    x = static_cast<uint16_t>(x ^ byte);
    x = static_cast<uint16_t>(x ^ ((x & 0xFF) >> 4));
    x = static_cast<uint16_t>(x ^ static_cast<uint16_t>(x << 12));
    return static_cast<uint16_t>(x ^ static_cast<uint16_t>((x & 0xFF) << 5));
}

inline uint16_t crc16(const char* data, uint8_t length) {
    uint16_t crc = kCrcStart;
    while (length--) crc = crc16_next(crc, static_cast<uint8_t>(*data++));
    return crc;
}

}  // namespace firmware
