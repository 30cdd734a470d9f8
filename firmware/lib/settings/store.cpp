// See store.h for the layout and for why the mark is written first and last.
#include "store.h"

#include "crc16.h"

namespace firmware {
namespace {

const uint8_t kErased = 0xFF;

}  // namespace

static_assert(4 + sizeof(Settings) + 2 <= Store::kSlotStride, "a record must fit its slot");
static_assert(sizeof(Settings) == 4 * (kSettingCount + kJoints * kTrimFieldCount), "no padding");

uint16_t Store::address(uint8_t slot, uint8_t offset) const {
    return static_cast<uint16_t>(kFirstSlot + slot * kSlotStride + offset);
}

bool Store::marked(uint8_t slot) {
    return eeprom_.read(address(slot, 0)) == kMark && eeprom_.read(address(slot, 1)) == kVersion;
}

bool Store::whole(uint8_t slot) {
    if (!marked(slot)) return false;
    uint16_t crc = kCrcStart;
    // The CRC of a record followed by its own CRC, high byte first, is 0.
    for (uint8_t i = 1; i < kRecord; ++i) crc = crc16_next(crc, eeprom_.read(address(slot, i)));
    return crc == 0;
}

uint16_t Store::serial(uint8_t slot) {
    const uint8_t low = eeprom_.read(address(slot, 2)), high = eeprom_.read(address(slot, 3));
    return static_cast<uint16_t>(low | static_cast<uint16_t>(high << 8));
}

Found Store::load(Settings& settings) {
    const bool good[2] = {whole(0), whole(1)};
    const bool bad = (marked(0) && !good[0]) || (marked(1) && !good[1]);
    if (!good[0] && !good[1]) return bad ? Found::Damaged : Found::New;
    uint8_t newest = good[0] ? 0 : 1;
    if (good[0] && good[1]) {
        newest = static_cast<int16_t>(serial(1) - serial(0)) > 0 ? 1 : 0;
    }
    uint8_t* const bytes = reinterpret_cast<uint8_t*>(&settings);
    for (uint8_t i = 0; i < sizeof settings; ++i) {
        bytes[i] = eeprom_.read(address(newest, static_cast<uint8_t>(4 + i)));
    }
    return bad ? Found::Older : Found::Ok;
}

void Store::save(const Settings& settings) {
    const bool good[2] = {whole(0), whole(1)};
    const bool second_is_newer =
        good[1] && (!good[0] || static_cast<int16_t>(serial(1) - serial(0)) > 0);
    const uint8_t newest = second_is_newer ? 1 : 0;
    slot_ = good[newest] ? static_cast<uint8_t>(1 - newest) : 0;
    serial_ = good[newest] ? static_cast<uint16_t>(serial(newest) + 1) : 0;
    settings_ = &settings;
    position_ = 0;
    crc_ = kCrcStart;
    for (uint8_t i = 1; i < kRecord - 2; ++i) crc_ = crc16_next(crc_, record_byte(i));
}

uint8_t Store::record_byte(uint8_t offset) const {
    switch (offset) {
        case 0:
            return kMark;
        case 1:
            return kVersion;
        case 2:
            return static_cast<uint8_t>(serial_ & 0xFF);
        case 3:
            return static_cast<uint8_t>(serial_ >> 8);
        case kRecord - 2:
            return static_cast<uint8_t>(crc_ >> 8);
        case kRecord - 1:
            return static_cast<uint8_t>(crc_ & 0xFF);
        default:
            return reinterpret_cast<const uint8_t*>(settings_)[offset - 4];
    }
}

// The byte due at the present position of the save; false when all are written.
bool Store::next(uint8_t& offset, uint8_t& byte) const {
    if (position_ > kRecord) return false;
    offset = position_ == kRecord ? 0 : position_;
    byte = position_ == 0 ? kErased : record_byte(offset);
    return true;
}

bool Store::step(bool& good) {
    if (settings_ == 0 || !eeprom_.ready()) return false;
    uint8_t offset, byte;
    while (next(offset, byte)) {
        ++position_;
        if (eeprom_.read(address(slot_, offset)) == byte) continue;
        eeprom_.write(address(slot_, offset), byte);
        return false;
    }
    good = true;
    for (uint8_t i = 0; i < kRecord; ++i) {
        if (eeprom_.read(address(slot_, i)) != record_byte(i)) good = false;
    }
    settings_ = 0;
    return true;
}

}  // namespace firmware
