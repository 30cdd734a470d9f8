// Settings in EEPROM: two copies, written in turn, so that a power cut at any byte loses nothing.
//
// A copy is: age, layout, number of joints, the settings, the trims of each joint, CRC (2 bytes).
// The age is 0, 1 or 2, and that of the newer copy follows that of the older one; after 2 comes 0.
// Saving overwrites the older copy: its age is erased first, then all else is written, and the new
// age comes last. So a copy that a power cut left half-written never has an age, whatever its bytes
// are. The CRC detects bytes that change later.
//
// A copy with another layout is ignored. If a copy was saved for another number of joints, the
// trims of the joints that both boards have are loaded; the other joints keep their defaults.
#pragma once

#include "eeprom.h"
#include "settings.h"

namespace firmware {

enum class LoadResult : uint8_t {
    Ok,       // newest copy
    New,      // no copy: defaults
    Older,    // only one copy is undamaged
    Damaged,  // no copy without damage: defaults
    Migrated  // copy for another number of joints
};

class Store {
  public:
    explicit Store(Eeprom& eeprom)
        : eeprom_(eeprom),
          settings_(0),
          crc_(0),
          offset_(0),
          job_(None),
          slot_(0),
          newest_(kNone),
          saving_(false),
          damaged_(false),
          good_(false) {}

    // Begin to load the newest undamaged copy. The settings must hold the defaults, which remain if
    // there is no such copy. They must not be used while busy() is true.
    void load(Settings& settings);
    // Begin to save. The settings must not change while busy() is true.
    void save(Settings& settings);

    bool busy() const { return job_ != None; }
    // Whether the present job, or the last one if none runs, is a save.
    bool saving() const { return saving_; }
    // Read or write one byte. Return whether this ended the load or save.
    bool step();

    LoadResult load_result();  // result of the last load
    // Whether there was an undamaged copy.
    bool loaded() const { return newest_ != kNone; }
    // After a save: whether the new copy was read back without damage.
    bool good() const { return good_; }

    static const uint8_t kLayout = 3;
    static const uint8_t kHead = 3;               // bytes before the settings: age, layout, joints
    static uint16_t slot_address(uint8_t slot);   // start of copy 0 or 1
    static uint16_t record_size(uint8_t joints);  // bytes of a copy with its CRC

  private:
    enum Job : uint8_t { None, Check, Copy, Write };
    static const uint8_t kNone = 0xFF;  // as a slot: none; as an age: half-written or never written

    void begin(Job job, uint8_t slot);
    uint8_t read(uint16_t offset);
    uint8_t next_age();
    uint8_t record_byte();
    void check_byte();
    void copy_byte();
    void write_byte();

    Eeprom& eeprom_;
    uint8_t* settings_;
    uint16_t crc_, offset_;  // offset_: next byte, from the start of the copy
    Job job_;
    uint8_t slot_, newest_;
    bool saving_, damaged_, good_;
};

}  // namespace firmware
