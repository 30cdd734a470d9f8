// What must happen before main(): keep the cause of the reset, stop the watchdog, mark unused RAM.
#pragma once

#include <stdint.h>

#include "controller.h"

firmware::Reset reset_cause();

// Bytes between the last variable and the deepest that the stack has been.
uint16_t untouched_ram();
