// Constant data in flash on an AVR, where RAM is short; plain constants on every other machine.
#pragma once

#include <stdint.h>

// The link-time optimiser would inline what is called once, and keep all of it in one stack frame.
#define OWN_FRAME [[gnu::noinline]]

#ifdef __AVR__
#include <avr/pgmspace.h>
#define FLASH PROGMEM
#define FLASH_TEXT(text) PSTR(text)
#else
#define FLASH
#define FLASH_TEXT(text) text
#endif

namespace firmware {

inline uint8_t flash_u8(const uint8_t* p) {
#ifdef __AVR__
    return pgm_read_byte(p);
#else
    return *p;
#endif
}

inline char flash_char(const char* p) {
    return static_cast<char>(flash_u8(reinterpret_cast<const uint8_t*>(p)));
}

inline uint16_t flash_u16(const uint16_t* p) {
#ifdef __AVR__
    return pgm_read_word(p);
#else
    return *p;
#endif
}

inline uint32_t flash_u32(const uint32_t* p) {
#ifdef __AVR__
    return pgm_read_dword(p);
#else
    return *p;
#endif
}

}  // namespace firmware
