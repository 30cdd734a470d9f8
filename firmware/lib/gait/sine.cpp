// The sine from a table: a quarter wave as 64 chords, raised so that the errors above and below the
// curve are equal.
//
// A chord over a step h = π/128 is up to h²/8 (a relative error of 7.5e-5) below the sine. The
// table holds round(32768 (1 + h²/16) sin(i h)), which halves this error. Rounding to 16 bits adds
// 3e-5, and the clipping of the crest at 32767 adds another 3e-5.
#include "sine.h"

#include "progmem.h"

namespace firmware {
namespace {

const uint16_t kQuarterWave[65] FLASH = {
    0,     804,   1608,  2411,  3212,  4011,  4808,  5602,  6393,  7180,  7962,  8740,  9512,
    10279, 11040, 11793, 12540, 13279, 14011, 14733, 15447, 16152, 16847, 17531, 18206, 18869,
    19521, 20161, 20789, 21404, 22006, 22596, 23171, 23733, 24280, 24813, 25331, 25834, 26320,
    26792, 27247, 27685, 28107, 28512, 28900, 29270, 29623, 29958, 30275, 30573, 30854, 31115,
    31358, 31582, 31787, 31973, 32140, 32287, 32415, 32523, 32611, 32680, 32730, 32759, 32769,
};

const uint32_t kQuarterTurn = 1UL << 30;

}  // namespace

int16_t sine_q15(uint32_t phase) {
    uint32_t angle = phase & (kQuarterTurn - 1);             // 2³² is a full turn
    if (phase & kQuarterTurn) angle = kQuarterTurn - angle;  // falling: read the table backwards
    const uint8_t i = static_cast<uint8_t>(angle >> 24);
    uint16_t y = flash_u16(&kQuarterWave[i]);
    if (i < 64) {
        const uint16_t rise = static_cast<uint16_t>(flash_u16(&kQuarterWave[i + 1]) - y);
        const uint16_t fraction = static_cast<uint16_t>(angle >> 8);  // of the chord, Q16
        y = static_cast<uint16_t>(y + ((static_cast<uint32_t>(rise) * fraction + 0x8000UL) >> 16));
    }
    const int16_t s = y > 32767 ? 32767 : static_cast<int16_t>(y);
    return (phase & (kQuarterTurn << 1)) ? static_cast<int16_t>(-s) : s;
}

}  // namespace firmware
