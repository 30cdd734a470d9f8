// Timer 1 on the ATmega328P, timer 5 on the ATmega2560; 16-bit registers need quiet interrupts.
#include "servo_timer.h"

#ifndef SERPENOID_PCA9685
#include <Arduino.h>
#include <util/atomic.h>

#ifdef TCNT5
#define COUNT TCNT5
#define COMPARE OCR5A
#else
#define COUNT TCNT1
#define COMPARE OCR1A
#endif

namespace servo_timer {
namespace {

const uint16_t kLibraryRefreshTicks = 40000;
uint16_t stretch_ticks = 0;  // how much longer ours is
bool stretched = false;

}  // namespace

void begin(uint16_t frame_us) {
    const uint16_t library_us = kLibraryRefreshTicks / 2;
    stretch_ticks = frame_us > library_us ? static_cast<uint16_t>(2 * (frame_us - library_us)) : 0;
}

uint16_t gap_ticks() {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        const uint16_t count =
            COUNT;  // past the compare, while its interrupt waits: no gap any more
        if (COMPARE != kLibraryRefreshTicks || count >= kLibraryRefreshTicks) return 0;
        stretched = false;
        return kLibraryRefreshTicks - count;
    }
    return 0;
}

void begin_in(uint16_t ticks) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { COUNT = kLibraryRefreshTicks - ticks; }
}

void stretch() {
    if (stretch_ticks == 0 || stretched) return;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        const uint16_t count = COUNT, end = COMPARE;
        // Not just before a pulse ends, nor in the gap.
        const bool safe = end != kLibraryRefreshTicks && count > stretch_ticks && end > count + 40;
        if (safe) {
            COMPARE = end - stretch_ticks;
            COUNT = COUNT - stretch_ticks + 1;  // the tick that these lines take
            stretched = true;
        }
    }
}

}  // namespace servo_timer
#endif
