// Settings in EEPROM: two copies, written in turn, so that a power cut at any byte loses nothing.
//
// A copy is: mark, layout, serial number (2), how many settings, how many joints, the settings, the
// trims of each joint, CRC (2). Saving takes the older copy: its mark goes first, then everything
// else is written, then the mark comes back. Whenever the power fails, the other copy is whole, and
// the half-written one has no mark: that is certain, not merely likely. The CRC is there for bytes
// that go bad later; a copy whose CRC is right and whose values are not is as bad as a damaged one.
//
// A copy by an older firmware, or for another number of joints, is taken over: what it has no value
// for keeps its default. Layout 1 had six settings and five joints and did not say so; its second
// copy stood at 256.
#pragma once

#include "eeprom.h"
#include "settings.h"

namespace firmware {

enum class Found : uint8_t { Ok, New, Older, Damaged, Migrated };

class Store {
  public:
    explicit Store(Eeprom& eeprom)
        : eeprom_(eeprom), settings_(0), position_(0), slot_(0), serial_(0), crc_(0) {}

    // The newest whole copy; settings must hold the defaults, and are left alone if it is New or
    // Damaged.
    Found load(Settings& settings);

    // Begin to save. The settings must not change until saving() is over.
    void save(const Settings& settings);
    bool saving() const { return settings_ != 0; }
    // Write the next byte that differs, if the EEPROM is ready. True when that ended the save;
    // `good` then says whether all of it reads back.
    bool step(bool& good);

    static const uint8_t kSlots = 3;  // two of ours and the second one of layout 1
    static const uint8_t kLayout = 2;
    static const uint8_t kMark = 0x5E;
    static const uint8_t kHead = 6;
    static const uint16_t kRecord = kHead + sizeof(Settings) + 2;
    static uint16_t slot_at(uint8_t slot);

  private:
    // What a copy holds, by its own account.
    struct Layout {
        uint8_t head, settings, joints;
        uint16_t bytes() const;
    };

    bool marked(uint8_t slot);
    Layout layout(uint8_t slot);
    bool whole(uint8_t slot);
    bool sane(uint8_t slot);
    int8_t newest(bool& damaged);
    uint16_t serial(uint8_t slot);
    int32_t value_at(uint16_t address);
    void trim_at(uint8_t slot, uint8_t joint, int32_t (&trim_u)[kTrimFieldCount]);
    uint8_t record_byte(uint16_t offset) const;
    bool next(uint16_t& offset, uint8_t& byte) const;

    Eeprom& eeprom_;
    const Settings* settings_;  // being saved, or null
    uint16_t position_;  // 0: take the mark away; 1 .. kRecord-1: the rest; kRecord: the mark again
    uint8_t slot_;
    uint16_t serial_, crc_;
};

}  // namespace firmware
