// See store.h for the layout and for why the mark is written first and last.
#include "store.h"

#include "crc16.h"

namespace firmware {
namespace {

const uint8_t kErased = 0xFF;
const uint16_t kSecondOfLayout1 = 256;
const uint8_t kMostSettings = 32, kMostJoints = 12;  // more is no number but damage

}  // namespace

static_assert(sizeof(Settings) == 4 * (kSettingCount + kJoints * kTrimFieldCount), "no padding");
static_assert(Store::kRecord <= 448, "a record must fit its slot");

// Behind the boot counter, and in the upper half of the 1024 bytes of a Uno.
uint16_t Store::slot_at(uint8_t slot) {
    return slot == 0 ? 64 : slot == 1 ? 512 : kSecondOfLayout1;
}

uint16_t Store::Layout::bytes() const {
    return static_cast<uint16_t>(head + 4 * (settings + joints * kTrimFieldCount) + 2);
}

bool Store::marked(uint8_t slot) {
    const uint16_t at = slot_at(slot);
    const uint8_t layout = eeprom_.read(static_cast<uint16_t>(at + 1));
    if (eeprom_.read(at) != kMark) return false;
    if (slot == 2) return layout == 1 && (slot_at(0) + kRecord <= at || !marked(0));
    return slot == 0 ? layout == 1 || layout == kLayout : layout == kLayout;
}

Store::Layout Store::layout(uint8_t slot) {
    const uint16_t at = slot_at(slot);
    if (eeprom_.read(static_cast<uint16_t>(at + 1)) == 1) return Layout{4, 6, 5};
    return Layout{kHead, eeprom_.read(static_cast<uint16_t>(at + 4)),
                  eeprom_.read(static_cast<uint16_t>(at + 5))};
}

bool Store::whole(uint8_t slot) {
    const Layout found = layout(slot);
    if (found.settings > kMostSettings || found.joints > kMostJoints) return false;
    uint16_t crc = kCrcStart;
    // The CRC of a record followed by its own CRC, high byte first, is 0.
    for (uint16_t i = 1; i < found.bytes(); ++i) {
        crc = crc16_next(crc, eeprom_.read(static_cast<uint16_t>(slot_at(slot) + i)));
    }
    return crc == 0;
}

int32_t Store::value_at(uint16_t address) {
    uint32_t value = 0;
    for (uint8_t i = 4; i > 0; --i) {
        value = value << 8 | eeprom_.read(static_cast<uint16_t>(address + i - 1));
    }
    return static_cast<int32_t>(value);
}

void Store::trim_at(uint8_t slot, uint8_t joint, int32_t (&trim_u)[kTrimFieldCount]) {
    const Layout found = layout(slot);
    const uint16_t at = static_cast<uint16_t>(slot_at(slot) + found.head +
                                              4 * (found.settings + joint * kTrimFieldCount));
    for (uint8_t f = 0; f < kTrimFieldCount; ++f) {
        trim_u[f] = value_at(static_cast<uint16_t>(at + 4 * f));
    }
}

// Whether every value is one that could have been set.
bool Store::sane(uint8_t slot) {
    const Layout found = layout(slot);
    for (uint8_t i = 0; i < found.settings && i < kSettingCount; ++i) {
        const uint16_t at = static_cast<uint16_t>(slot_at(slot) + found.head + 4 * i);
        if (!in_range(setting_field(i), value_at(at))) return false;
    }
    int32_t trim_u[kTrimFieldCount], beyond_us;
    for (uint8_t j = 0; j < found.joints; ++j) {
        trim_at(slot, j, trim_u);
        for (uint8_t f = 0; f < kTrimFieldCount; ++f) {
            if (!in_range(trim_field(f), trim_u[f])) return false;
        }
        if (!within_pulses(trim_u, beyond_us)) return false;
    }
    return true;
}

uint16_t Store::serial(uint8_t slot) {
    const uint16_t at = static_cast<uint16_t>(slot_at(slot) + 2);
    const uint8_t low = eeprom_.read(at), high = eeprom_.read(static_cast<uint16_t>(at + 1));
    return static_cast<uint16_t>(low | static_cast<uint16_t>(high << 8));
}

// The slot of the newest good copy, or -1.
int8_t Store::newest(bool& damaged) {
    int8_t found = -1;
    damaged = false;
    for (uint8_t slot = 0; slot < kSlots; ++slot) {
        if (!marked(slot)) continue;
        if (!whole(slot) || !sane(slot)) {
            damaged = true;
            continue;
        }
        const bool newer = found < 0 || static_cast<int16_t>(
                                            serial(slot) - serial(static_cast<uint8_t>(found))) > 0;
        if (newer) found = static_cast<int8_t>(slot);
    }
    return found;
}

Found Store::load(Settings& settings) {
    bool damaged;
    const int8_t best = newest(damaged);
    if (best < 0) return damaged ? Found::Damaged : Found::New;
    const uint8_t slot = static_cast<uint8_t>(best);
    const Layout found = layout(slot);
    for (uint8_t i = 0; i < found.settings && i < kSettingCount; ++i) {
        settings.value_u[i] = value_at(static_cast<uint16_t>(slot_at(slot) + found.head + 4 * i));
    }
    for (uint8_t j = 0; j < found.joints && j < kJoints; ++j) {
        trim_at(slot, j, settings.trim_u[j]);
    }
    if (found.settings != kSettingCount || found.joints != kJoints) return Found::Migrated;
    return damaged ? Found::Older : Found::Ok;
}

void Store::save(const Settings& settings) {
    bool damaged;
    const int8_t best = newest(damaged);
    slot_ = best == 0 || best == 2 ? 1 : 0;
    serial_ = best < 0 ? 0 : static_cast<uint16_t>(serial(static_cast<uint8_t>(best)) + 1);
    settings_ = &settings;
    position_ = 0;
    crc_ = kCrcStart;
    for (uint16_t i = 1; i < kRecord - 2; ++i) crc_ = crc16_next(crc_, record_byte(i));
}

uint8_t Store::record_byte(uint16_t offset) const {
    switch (offset) {
        case 0:
            return kMark;
        case 1:
            return kLayout;
        case 2:
            return static_cast<uint8_t>(serial_ & 0xFF);
        case 3:
            return static_cast<uint8_t>(serial_ >> 8);
        case 4:
            return kSettingCount;
        case 5:
            return kJoints;
        case kRecord - 2:
            return static_cast<uint8_t>(crc_ >> 8);
        case kRecord - 1:
            return static_cast<uint8_t>(crc_ & 0xFF);
        default:
            return reinterpret_cast<const uint8_t*>(settings_)[offset - kHead];
    }
}

// The byte due at the present position of the save; false when all are written.
bool Store::next(uint16_t& offset, uint8_t& byte) const {
    if (position_ > kRecord) return false;
    offset = position_ == kRecord ? 0 : position_;
    byte = position_ == 0 ? kErased : record_byte(offset);
    return true;
}

bool Store::step(bool& good) {
    if (settings_ == 0 || !eeprom_.ready()) return false;
    uint16_t offset;
    uint8_t byte;
    while (next(offset, byte)) {
        ++position_;
        const uint16_t at = static_cast<uint16_t>(slot_at(slot_) + offset);
        if (eeprom_.read(at) == byte) continue;
        eeprom_.write(at, byte);
        return false;
    }
    good = true;
    for (uint16_t i = 0; i < kRecord; ++i) {
        if (eeprom_.read(static_cast<uint16_t>(slot_at(slot_) + i)) != record_byte(i)) good = false;
    }
    settings_ = 0;
    return true;
}

}  // namespace firmware
