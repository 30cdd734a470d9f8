// The EEPROM as the settings see it: bytes; a write takes 3.4 ms, and the power may fail in any of
// them.
#pragma once

#include <stdint.h>

namespace firmware {

class Eeprom {
  public:
    virtual uint8_t read(uint16_t address) = 0;
    // Start writing one byte; waits first if another write is under way.
    virtual void write(uint16_t address, uint8_t byte) = 0;
    // No write is under way.
    virtual bool ready() = 0;

  protected:
    ~Eeprom() {}
};

}  // namespace firmware
