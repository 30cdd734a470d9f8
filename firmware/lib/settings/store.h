// Settings in EEPROM: two copies, written in turn, so that a power cut at any byte loses nothing.
//
// A copy is: age, layout, number of joints, the settings, the trims of each joint, CRC (2). The age
// is 0, 1 or 2, and that of the newer copy follows that of the older one; after 2 comes 0. Saving
// overwrites the older copy: its age goes first, then all else is written, and the new age comes
// last. A copy that a power cut left half-written has no age: that is certain, not merely likely.
// The CRC is there for bytes that go bad later.
//
// A copy of another layout counts as none. Of a copy for another number of joints, the trims of the
// joints that both have are taken, and the others keep their defaults.
#pragma once

#include "eeprom.h"
#include "settings.h"

namespace firmware {

enum class LoadResult : uint8_t { Ok, New, Older, Damaged, Migrated };

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

    // Begin to load the newest whole copy; settings must hold the defaults, and are left alone if
    // there is none. They must not be used until busy() is over.
    void load(Settings& settings);
    // Begin to save. The settings must not change until busy() is over.
    void save(Settings& settings);

    bool busy() const { return job_ != None; }
    bool saving() const { return saving_; }  // the job, or the last one
    // Read or write one byte; true when that ended the job.
    bool step();

    LoadResult load_result();                         // by the last load
    bool loaded() const { return newest_ != kNone; }  // there was a copy to load
    bool good() const { return good_; }               // the last save reads back

    static const uint8_t kLayout = 3;
    static const uint8_t kHead = 3;
    static uint16_t slot_address(uint8_t slot);
    static uint16_t record_size(uint8_t joints);

  private:
    enum Job : uint8_t { None, Check, Copy, Write };
    static const uint8_t kNone = 0xFF;  // no slot; as an age: no copy

    void begin(Job job, uint8_t slot);
    uint8_t read(uint16_t offset);
    uint8_t next_age();
    uint8_t record_byte();
    void check_byte();
    void copy_byte();
    void write_byte();

    Eeprom& eeprom_;
    uint8_t* settings_;
    uint16_t crc_, offset_;  // offset_: of the byte in its copy
    Job job_;
    uint8_t slot_, newest_;
    bool saving_, damaged_, good_;
};

}  // namespace firmware
