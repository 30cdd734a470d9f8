// The cause of a reset, and unused RAM. A boot loader may clear MCUSR, which holds the cause; newer
// ones (Optiboot) pass its value in r2.
#include "start.h"

#include <avr/io.h>
#include <avr/wdt.h>

extern uint8_t _end;  // the address after the last variable, set by the linker

namespace {

const uint8_t kMark = 0xC5;
const uint8_t kMaxGap = 128;  // greatest number of unused bytes within the stack
uint8_t mcusr_at_start __attribute__((section(".noinit")));
uint8_t r2_at_start __attribute__((section(".noinit")));

}  // namespace

// Runs before variables are set, and must not use the stack. After a watchdog reset the watchdog is
// still on with its shortest time, so it is switched off here.
void before_main() __attribute__((naked, used, section(".init3")));
void before_main() {
    __asm__ __volatile__("sts %0, r2" : "=m"(r2_at_start));
    mcusr_at_start = MCUSR;
    MCUSR = 0;
    wdt_disable();
    for (uint8_t* p = &_end; p <= reinterpret_cast<uint8_t*>(RAMEND); ++p) *p = kMark;
}

// The order matters: power-up usually sets the brown-out flag too, and Optiboot sets the watchdog
// flag after an external reset.
firmware::Reset reset_cause() {
    const uint8_t boot_flags = r2_at_start < 16 ? r2_at_start : 0;
    const uint8_t flags = mcusr_at_start != 0 ? mcusr_at_start : boot_flags;
    if (flags & _BV(PORF)) return firmware::Reset::Power;
    if (flags & _BV(BORF)) return firmware::Reset::Brownout;
    if (flags & _BV(EXTRF)) return firmware::Reset::External;
    if (flags & _BV(WDRF)) return firmware::Reset::Watchdog;
    return firmware::Reset::Unknown;
}

// Each call continues from the deepest byte found before. A search from the end of the variables
// would take 7 ms for the 6 kB of a Mega, and delay a frame.
uint16_t untouched_ram() {
    static const uint8_t* deepest = reinterpret_cast<const uint8_t*>(RAMEND);
    for (const uint8_t* p = deepest; p > &_end && deepest - p < kMaxGap;) {
        if (*--p != kMark) deepest = p;
    }
    return static_cast<uint16_t>(deepest - &_end);
}
