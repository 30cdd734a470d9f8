// Sine of a wrapping phase by table and linear interpolation, in integers alone.
#pragma once

#include <stdint.h>

namespace firmware {

// sin(2π phase / 2³²) in Q15 (32768 is 1), within 7e-5 of the true value everywhere.
int16_t sine_q15(uint32_t phase);

}  // namespace firmware
