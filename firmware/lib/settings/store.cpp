// See store.h for the layout and for why the mark is written first and last.
#include "store.h"

#include "crc16.h"

namespace firmware {
namespace {

const uint8_t kErased = 0xFF;
const uint8_t kBeforeFirst = 0xFF;                   // slot; the next one is 0
const uint8_t kSlice = 32;                           // bytes
const uint8_t kMostSettings = 32, kMostJoints = 12;  // more is no number but damage

}  // namespace

static_assert(sizeof(Settings) == 4 * (kSettingCount + kJoints * kTrimFieldCount), "no padding");
static_assert(Store::kRecord <= 448, "a record must fit its slot");

// Behind the boot counter, and in the upper half of the 1024 bytes of a Uno.
uint16_t Store::slot_at(uint8_t slot) { return slot == 0 ? 64 : 512; }

uint16_t Store::Counts::bytes() const {
    return static_cast<uint16_t>(kHead + 4 * (settings + joints * kTrimFieldCount) + 2);
}

// The layout of a copy, or 0 if there is none.
uint8_t Store::layout(uint8_t slot) {
    const uint16_t at = slot_at(slot);
    const uint8_t layout = eeprom_.read(static_cast<uint16_t>(at + 1));
    return eeprom_.read(at) == kMark && layout != kErased ? layout : 0;
}

Store::Counts Store::counts(uint8_t slot) {
    const uint16_t at = slot_at(slot);
    return Counts{eeprom_.read(static_cast<uint16_t>(at + 4)),
                  eeprom_.read(static_cast<uint16_t>(at + 5))};
}

int32_t Store::value_at(uint16_t address) {
    uint32_t value = 0;
    for (uint8_t i = 4; i > 0; --i) {
        value = value << 8 | eeprom_.read(static_cast<uint16_t>(address + i - 1));
    }
    return static_cast<int32_t>(value);
}

int32_t Store::setting_in(uint8_t setting) {
    return value_at(static_cast<uint16_t>(slot_at(slot_) + kHead + 4 * setting));
}

void Store::trim_in(const Counts& found, uint8_t joint, int32_t (&trim_u)[kTrimFieldCount]) {
    const uint8_t first = static_cast<uint8_t>(found.settings + joint * kTrimFieldCount);
    for (uint8_t f = 0; f < kTrimFieldCount; ++f) {
        trim_u[f] = setting_in(static_cast<uint8_t>(first + f));
    }
}

// Whether every value of a row is one that could have been set.
bool Store::row_is_sane(const Counts& found, uint8_t row) {
    if (row == 0) {
        for (uint8_t i = 0; i < found.settings && i < kSettingCount; ++i) {
            if (!in_range(setting_field(i), setting_in(i))) return false;
        }
        return true;
    }
    int32_t trim_u[kTrimFieldCount], beyond_us;
    trim_in(found, static_cast<uint8_t>(row - 1), trim_u);
    for (uint8_t f = 0; f < kTrimFieldCount; ++f) {
        if (!in_range(trim_field(f), trim_u[f])) return false;
    }
    return within_pulses(trim_u, beyond_us);
}

uint16_t Store::serial(uint8_t slot) {
    const uint16_t at = static_cast<uint16_t>(slot_at(slot) + 2);
    const uint8_t low = eeprom_.read(at), high = eeprom_.read(static_cast<uint16_t>(at + 1));
    return static_cast<uint16_t>(low | static_cast<uint16_t>(high << 8));
}

void Store::load(Settings& settings) {
    settings_ = &settings;
    job_ = Job::Check;
    best_ = -1;
    damaged_ = newer_ = false;
    slot_ = kBeforeFirst;
}

// Go on with the next copy that is there, or end the search.
void Store::next_slot() {
    position_ = 1;  // the mark is not in the CRC
    crc_ = kCrcStart;
    while (++slot_ < kSlots) {
        const uint8_t found = layout(slot_);
        newer_ = newer_ || found > kLayout;
        if (found == kLayout) return;
    }
    end_of_checks();
}

// The CRC of a record followed by its own CRC, high byte first, is 0.
bool Store::check_slice() {
    if (slot_ == kBeforeFirst) {
        next_slot();
        return job_ == Job::None;
    }
    const Counts found = counts(slot_);
    const bool possible = found.settings <= kMostSettings && found.joints <= kMostJoints;
    if (possible && position_ < found.bytes()) {
        for (uint8_t n = 0; n < kSlice && position_ < found.bytes(); ++n, ++position_) {
            crc_ =
                crc16_next(crc_, eeprom_.read(static_cast<uint16_t>(slot_at(slot_) + position_)));
        }
    } else if (possible && crc_ == 0) {
        check_row(found);
    } else {
        damaged_ = true;
        next_slot();
    }
    return job_ == Job::None;
}

void Store::check_row(const Counts& found) {
    const uint8_t row = static_cast<uint8_t>(position_ - found.bytes());
    const bool sane = row_is_sane(found, row);
    if (sane && row < found.joints) {
        ++position_;
        return;
    }
    if (!sane) damaged_ = true;
    const bool newer_copy =
        best_ < 0 || static_cast<int16_t>(serial(slot_) - serial(static_cast<uint8_t>(best_))) > 0;
    if (sane && newer_copy) best_ = static_cast<int8_t>(slot_);
    next_slot();
}

void Store::end_of_checks() {
    job_ = best_ < 0 ? Job::None : Job::Copy;
    if (best_ < 0) return;
    slot_ = static_cast<uint8_t>(best_);
    newer_ = newer_ || counts(slot_).settings > kSettingCount;
    position_ = 0;
}

bool Store::copy_row() {
    const Counts found = counts(slot_);
    const uint8_t row = static_cast<uint8_t>(position_++);
    if (row == 0) {
        for (uint8_t i = 0; i < found.settings && i < kSettingCount; ++i) {
            settings_->value_u[i] = setting_in(i);
        }
    } else if (row <= found.joints && row <= kJoints) {
        trim_in(found, static_cast<uint8_t>(row - 1), settings_->trim_u[row - 1]);
    } else {
        job_ = Job::None;
    }
    return job_ == Job::None;
}

Found Store::found() {
    if (newer_) return Found::Newer;
    if (best_ < 0) return damaged_ ? Found::Damaged : Found::New;
    const Counts copy = counts(static_cast<uint8_t>(best_));
    const bool migrated = copy.settings != kSettingCount || copy.joints != kJoints;
    return migrated ? Found::Migrated : damaged_ ? Found::Older : Found::Ok;
}

void Store::save(Settings& settings) {
    slot_ = best_ == 0 ? 1 : 0;
    serial_ = best_ < 0 ? 0 : static_cast<uint16_t>(serial(static_cast<uint8_t>(best_)) + 1);
    settings_ = &settings;
    job_ = Job::Save;
    position_ = 0;
    crc_ = kCrcStart;
    good_ = true;
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

// Take away the mark of one copy of a newer layout; false if there is none left.
bool Store::forget_newer() {
    for (uint8_t slot = 0; newer_ && slot < kSlots; ++slot) {
        if (layout(slot) <= kLayout) continue;
        eeprom_.write(slot_at(slot), kErased);
        return true;
    }
    newer_ = false;
    return false;
}

bool Store::save_slice() {
    if (forget_newer()) return false;
    for (uint8_t n = 0; n < kSlice; ++n) {
        const uint16_t step = position_++;
        const bool reads_back = step > kRecord;
        const uint16_t offset = reads_back        ? static_cast<uint16_t>(step - kRecord - 1)
                                : step == kRecord ? 0
                                                  : step;
        if (offset == kRecord) {
            job_ = Job::None;
            if (good_) best_ = static_cast<int8_t>(slot_);
            return true;
        }
        const uint8_t byte = step == 0 ? kErased : record_byte(offset);
        const uint16_t at = static_cast<uint16_t>(slot_at(slot_) + offset);
        if (step > 0 && step < kRecord - 2) crc_ = crc16_next(crc_, byte);
        if (eeprom_.read(at) == byte) continue;
        if (reads_back) {
            good_ = false;
            continue;
        }
        eeprom_.write(at, byte);
        return false;
    }
    return false;
}

// Only at a start a read may have to wait for a write, that of the boot counter.
bool Store::step() {
    switch (job_) {
        case Job::Check:
            return check_slice();
        case Job::Copy:
            return copy_row();
        case Job::Save:
            return eeprom_.ready() && save_slice();
        case Job::None:
            break;
    }
    return false;
}

}  // namespace firmware
