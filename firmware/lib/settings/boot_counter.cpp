// The cells hold consecutive numbers up to the newest, where the sequence breaks off.
//
// If the power fails between the two bytes of a cell, the sequence breaks before that cell and the
// next start takes the same number: the start that failed had told it to nobody.
#include "boot_counter.h"

namespace firmware {
namespace {

const uint8_t kCells = 8;

uint16_t cell(Eeprom& eeprom, uint8_t index) {
    const uint16_t address = static_cast<uint16_t>(2 * index);
    const uint8_t low = eeprom.read(address);
    return static_cast<uint16_t>(low | static_cast<uint16_t>(eeprom.read(address + 1U) << 8));
}

}  // namespace

uint16_t count_boot(Eeprom& eeprom) {
    uint8_t newest = 0;
    while (newest + 1 < kCells && cell(eeprom, static_cast<uint8_t>(newest + 1)) ==
                                      static_cast<uint16_t>(cell(eeprom, newest) + 1)) {
        ++newest;
    }
    const uint16_t id = static_cast<uint16_t>(cell(eeprom, newest) + 1);
    const uint16_t address = static_cast<uint16_t>(2 * ((newest + 1) % kCells));
    eeprom.write(address, static_cast<uint8_t>(id & 0xFF));
    eeprom.write(static_cast<uint16_t>(address + 1), static_cast<uint8_t>(id >> 8));
    return id;
}

}  // namespace firmware
