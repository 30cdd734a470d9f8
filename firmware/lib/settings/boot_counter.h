// A number that is different after every start, kept through power loss, spread over 8 cells.
#pragma once

#include "eeprom.h"

namespace firmware {

// Counts one start and returns its number. Writes two bytes; each cell is written every 8th start.
uint16_t count_boot(Eeprom& eeprom);

}  // namespace firmware
