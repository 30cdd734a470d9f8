// Settings in EEPROM: two copies, written in turn, so that a power cut at any byte loses nothing.
//
// A copy is: mark, layout, serial number (2), how many settings, how many joints, the settings, the
// trims of each joint, CRC (2). Saving takes the older copy: its mark goes first, then everything
// else is written, then the mark comes back. Whenever the power fails, the other copy is whole, and
// the half-written one has no mark: that is certain, not merely likely. The CRC is there for bytes
// that go bad later; a copy whose CRC is right and whose values are not is as bad as a damaged one.
//
// A copy by an older firmware, or for another number of joints, is taken over: what it has no value
// for keeps its default. A copy of a newer firmware is not overwritten unless save() is told to.
//
// Reading and checking all copies takes 10 ms on a Uno: both jobs are done in slices.
#pragma once

#include "eeprom.h"
#include "settings.h"

namespace firmware {

enum class Found : uint8_t { Ok, New, Older, Damaged, Migrated, Newer };

class Store {
  public:
    explicit Store(Eeprom& eeprom)
        : eeprom_(eeprom),
          settings_(0),
          job_(Job::None),
          position_(0),
          serial_(0),
          crc_(0),
          slot_(0),
          best_(-1),
          damaged_(false),
          newer_(false),
          good_(false) {}

    // Begin to load the newest whole copy; settings must hold the defaults, and are left alone if
    // there is none. They must not be used until busy() is over.
    void load(Settings& settings);
    // Begin to save. The settings must not change until busy() is over.
    void save(Settings& settings);

    bool busy() const { return job_ != Job::None; }
    bool saving() const { return job_ == Job::Save; }
    // One slice, some 0.5 ms on a Uno. True when that ended the job.
    bool step();

    Found found();                              // by the last load
    bool loaded() const { return best_ >= 0; }  // there was a copy to load
    bool newer() const { return newer_; }       // a copy of a newer firmware is there
    bool good() const { return good_; }         // the last save reads back

    static const uint8_t kSlots = 2;
    static const uint8_t kLayout = 2;
    static const uint8_t kMark = 0x5E;
    static const uint8_t kHead = 6;
    static const uint16_t kRecord = kHead + sizeof(Settings) + 2;
    static uint16_t slot_at(uint8_t slot);

  private:
    enum class Job : uint8_t { None, Check, Copy, Save };

    // What a copy holds, by its own account.
    struct Counts {
        uint8_t settings, joints;
        uint16_t bytes() const;
    };

    uint8_t layout(uint8_t slot);
    Counts counts(uint8_t slot);
    bool check_slice();
    void check_row(const Counts& found);
    void next_slot();
    bool row_is_sane(const Counts& found, uint8_t row);
    void end_of_checks();
    bool copy_row();
    bool save_slice();
    bool forget_newer();
    uint16_t serial(uint8_t slot);
    int32_t value_at(uint16_t address);
    int32_t setting_in(uint8_t setting);
    void trim_in(const Counts& found, uint8_t joint, int32_t (&trim_u)[kTrimFieldCount]);
    uint8_t record_byte(uint16_t offset) const;

    Eeprom& eeprom_;
    Settings* settings_;
    Job job_;
    // Check: the byte to check, then behind the last one rows of values: the settings, then each
    // joint. Copy: the row. Save: 0 takes the mark away; 1 .. kRecord-1: the rest; kRecord: the
    // mark again; behind it every byte is read back.
    uint16_t position_;
    uint16_t serial_, crc_;
    uint8_t slot_;  // being checked, copied or saved
    int8_t best_;   // the newest good copy, or -1
    bool damaged_, newer_, good_;
};

}  // namespace firmware
