// A bootloader may clear MCUSR; newer ones (Optiboot) hand its value on in r2, older ones hide it.
#include "start.h"

#include <avr/io.h>
#include <avr/wdt.h>

extern uint8_t _end;  // linker: behind the last variable

namespace {

const uint8_t kMark = 0xC5;
const uint8_t kWidestGap = 128;  // bytes of a stack frame that may lie between two used ones
uint8_t mcusr_at_start __attribute__((section(".noinit")));
uint8_t r2_at_start __attribute__((section(".noinit")));

}  // namespace

// Runs after the stack pointer is set and before variables are; it must not use the stack. After a
// watchdog reset the watchdog is still on, at its shortest: it goes off first.
void before_main() __attribute__((naked, used, section(".init3")));
void before_main() {
    __asm__ __volatile__("sts %0, r2" : "=m"(r2_at_start));
    mcusr_at_start = MCUSR;
    MCUSR = 0;
    wdt_disable();
    for (uint8_t* p = &_end; p <= reinterpret_cast<uint8_t*>(RAMEND); ++p) *p = kMark;
}

// A power-up usually sets the brown-out flag too; an Optiboot that ran out of time after an
// external reset adds the watchdog flag: hence the order.
firmware::Reset reset_cause() {
    const uint8_t handed_on = r2_at_start < 16 ? r2_at_start : 0;
    const uint8_t flags = mcusr_at_start != 0 ? mcusr_at_start : handed_on;
    if (flags & _BV(PORF)) return firmware::Reset::Power;
    if (flags & _BV(BORF)) return firmware::Reset::Brownout;
    if (flags & _BV(EXTRF)) return firmware::Reset::External;
    if (flags & _BV(WDRF)) return firmware::Reset::Watchdog;
    return firmware::Reset::Unknown;
}

// The stack only ever gets deeper: each call goes on from the deepest place known. From the bottom
// up it would walk a Mega's 6 kB, 7 ms, in which a frame is late.
uint16_t untouched_ram() {
    static const uint8_t* deepest = reinterpret_cast<const uint8_t*>(RAMEND);
    for (const uint8_t* p = deepest; p > &_end && deepest - p < kWidestGap;) {
        if (*--p != kMark) deepest = p;
    }
    return static_cast<uint16_t>(deepest - &_end);
}
