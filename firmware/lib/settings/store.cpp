// The steps of store.h, which explains the layout, and why the age is written first and last.
#include "store.h"

#include "crc16.h"

namespace firmware {
namespace {

const uint16_t kAge = 0, kLayoutByte = 1, kJointsByte = 2;  // offsets in a copy
const uint8_t kAges = 3;
const uint8_t kMaxStoredJoints = 12;  // greatest number of any board; a larger one is damage

}  // namespace

// After the boot counter, and in the upper half of the 1024 bytes of an Uno.
uint16_t Store::slot_address(uint8_t slot) { return slot == 0 ? 64 : 512; }

uint16_t Store::record_size(uint8_t joints) {
    return static_cast<uint16_t>(kHead + 4 * (kSettingCount + joints * kTrimFieldCount) + 2);
}

uint8_t Store::read(uint16_t offset) {
    return eeprom_.read(static_cast<uint16_t>(slot_address(slot_) + offset));
}

void Store::begin(Job job, uint8_t slot) {
    job_ = job;
    slot_ = slot;
    offset_ = 0;
    crc_ = kCrcStart;
}

// The age of a copy that is newer than the newest one.
uint8_t Store::next_age() {
    if (newest_ == kNone) return 0;
    return static_cast<uint8_t>((eeprom_.read(slot_address(newest_)) + 1) % kAges);
}

void Store::load(Settings& settings) {
    settings_ = reinterpret_cast<uint8_t*>(&settings);
    newest_ = kNone;
    saving_ = damaged_ = false;
    begin(Check, 0);
}

void Store::save(Settings& settings) {
    settings_ = reinterpret_cast<uint8_t*>(&settings);
    saving_ = true;
    begin(Write, newest_ == 0 ? 1 : 0);
}

// The CRC of a record followed by its own CRC, high byte first, is 0.
void Store::check_byte() {
    const uint8_t age = read(kAge), joints = read(kJointsByte);
    const bool present = age < kAges && read(kLayoutByte) == kLayout;
    if (present && joints <= kMaxStoredJoints && offset_ < record_size(joints)) {
        crc_ = crc16_next(crc_, read(offset_++));
        return;
    }
    good_ = present && crc_ == 0;
    damaged_ = damaged_ || (present && !good_);
    if (good_ && (newest_ == kNone || age == next_age())) newest_ = slot_;
    if (!saving_ && slot_ == 0) return begin(Check, 1);
    begin(saving_ || newest_ == kNone ? None : Copy, newest_);
}

void Store::copy_byte() {
    const uint8_t stored = read(kJointsByte), joints = stored < joint_count ? stored : joint_count;
    settings_[offset_] = read(static_cast<uint16_t>(kHead + offset_));
    if (++offset_ == record_size(joints) - kHead - 2) job_ = None;
}

// The byte at offset_. Bytes must be requested in order, as the CRC is that of all bytes before it.
uint8_t Store::record_byte() {
    const uint8_t head[kHead] = {next_age(), kLayout, joint_count};
    const int16_t crc_offset = static_cast<int16_t>(offset_ - record_size(joint_count) + 2);
    if (crc_offset >= 0) return static_cast<uint8_t>(crc_offset == 0 ? crc_ >> 8 : crc_);
    const uint8_t byte = offset_ < kHead ? head[offset_] : settings_[offset_ - kHead];
    crc_ = crc16_next(crc_, byte);
    return byte;
}

void Store::write_byte() {
    const bool last = offset_ == record_size(joint_count);
    const uint16_t offset = last ? kAge : offset_;
    uint8_t byte = last ? next_age() : record_byte();
    if (offset_ == kAge) byte = kNone;
    ++offset_;
    if (read(offset) != byte) {
        eeprom_.write(static_cast<uint16_t>(slot_address(slot_) + offset), byte);
    }
    if (last) begin(Check, slot_);
}

// A load does not check that the EEPROM is ready, because at a start it may wait for the boot
// counter.
bool Store::step() {
    if (job_ == None || (saving_ && !eeprom_.ready())) return false;
    if (job_ == Check) {
        check_byte();
    } else if (job_ == Copy) {
        copy_byte();
    } else {
        write_byte();
    }
    return job_ == None;
}

LoadResult Store::load_result() {
    if (newest_ == kNone) return damaged_ ? LoadResult::Damaged : LoadResult::New;
    slot_ = newest_;
    if (read(kJointsByte) != joint_count) return LoadResult::Migrated;
    return damaged_ ? LoadResult::Older : LoadResult::Ok;
}

}  // namespace firmware
