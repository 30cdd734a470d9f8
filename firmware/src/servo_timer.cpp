// Timer 1 on the ATmega328P, timer 5 on the ATmega2560; 16-bit registers need quiet interrupts.
#include "servo_timer.h"

#include <Arduino.h>
#include <util/atomic.h>

#include "gait.h"

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
// How much longer ours is.
const uint16_t kStretchTicks = 2 * (firmware::kFrameUs - 20000);
bool stretched = false;

}  // namespace

uint16_t gap_ticks() {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        const uint16_t now = COUNT;  // past the compare, while its interrupt waits: no gap any more
        if (COMPARE != kLibraryRefreshTicks || now >= kLibraryRefreshTicks) return 0;
        stretched = false;
        return kLibraryRefreshTicks - now;
    }
    return 0;
}

void begin_in(uint16_t ticks) {
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { COUNT = kLibraryRefreshTicks - ticks; }
}

void stretch() {
    if (kStretchTicks == 0 || stretched) return;
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
        const uint16_t now = COUNT, end = COMPARE;
        // Not just before a pulse ends, nor in the gap.
        const bool safe = end != kLibraryRefreshTicks && now > kStretchTicks && end > now + 40;
        if (safe) {
            COMPARE = end - kStretchTicks;
            COUNT = COUNT - kStretchTicks + 1;  // the tick that these lines take
            stretched = true;
        }
    }
}

}  // namespace servo_timer
