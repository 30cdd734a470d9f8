// Settings in EEPROM: two copies, written in turn, so that a power cut at any byte loses nothing.
//
// A copy is: mark, version, serial number (2), settings, CRC (2). Saving takes the older copy: its
// mark goes first, then everything else is written, then the mark comes back. Whenever the power
// fails, the other copy is whole, and the half-written one has no mark: that is certain, not merely
// likely. The CRC is there for bytes that go bad later.
#pragma once

#include "eeprom.h"
#include "settings.h"

namespace firmware {

enum class Found : uint8_t { Ok, New, Older, Damaged };

class Store {
  public:
    explicit Store(Eeprom& eeprom)
        : eeprom_(eeprom), settings_(0), slot_(0), position_(0), serial_(0), crc_(0) {}

    // The newest whole copy; settings are left alone unless Ok or Older is returned.
    Found load(Settings& settings);

    // Begin to save. The settings must not change until saving() is over.
    void save(const Settings& settings);
    bool saving() const { return settings_ != 0; }
    // Write the next byte that differs, if the EEPROM is ready. True when that ended the save;
    // `good` then says whether all of it reads back.
    bool step(bool& good);

    static const uint16_t kFirstSlot = 64;  // behind the boot counter
    static const uint16_t kSlotStride = 192;
    static const uint8_t kVersion = 1;
    static const uint8_t kMark = 0x5E;
    static const uint8_t kRecord = 4 + sizeof(Settings) + 2;

  private:
    uint16_t address(uint8_t slot, uint8_t offset) const;
    bool marked(uint8_t slot);
    bool whole(uint8_t slot);
    uint16_t serial(uint8_t slot);
    uint8_t record_byte(uint8_t offset) const;
    bool next(uint8_t& offset, uint8_t& byte) const;

    Eeprom& eeprom_;
    const Settings* settings_;  // being saved, or null
    uint8_t slot_;
    uint8_t position_;  // 0: take the mark away; 1 .. kRecord-1: the rest; kRecord: the mark again
    uint16_t serial_, crc_;
};

}  // namespace firmware
