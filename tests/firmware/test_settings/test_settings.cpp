// Settings: units, and EEPROM whose power fails at every byte of every save.
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "boot_counter.h"
#include "crc16.h"
#include "doctest_main.h"
#include "settings.h"
#include "store.h"

using namespace firmware;

namespace {

Settings default_settings() {
    Settings settings;
    set_defaults(settings);
    return settings;
}

// An EEPROM whose power can fail: in the write where it does, the byte may be torn.
struct Memory : Eeprom {
    std::vector<uint8_t> bytes = std::vector<uint8_t>(1024, 0xFF);
    int writes_left = -1;
    int torn = -1;  // what the torn byte holds; -1: its old value
    int writes = 0;

    uint8_t read(uint16_t address) override { return bytes.at(address); }
    bool ready() override { return true; }
    void write(uint16_t address, uint8_t byte) override {
        if (writes_left == 0) return;
        ++writes;
        if (writes_left > 0 && --writes_left == 0) {
            if (torn >= 0) bytes.at(address) = static_cast<uint8_t>(torn);
            return;
        }
        bytes.at(address) = byte;
    }
};

bool save(Memory& memory, const Settings& settings) {
    Store store(memory);
    store.save(settings);
    bool good = false;
    for (int k = 0; k < 1000 && store.saving(); ++k) store.step(good);
    REQUIRE_FALSE(store.saving());
    return good;
}

bool same(const Settings& a, const Settings& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

Settings some_settings(uint32_t seed) {
    std::mt19937 random(seed);
    Settings settings = default_settings();
    for (int32_t& v : settings.value_u) v = static_cast<int32_t>(static_cast<uint32_t>(random()));
    for (auto& trim : settings.trim_u) {
        for (int32_t& v : trim) v = static_cast<int32_t>(static_cast<uint32_t>(random()));
    }
    return settings;
}

}  // namespace

TEST_CASE("a new EEPROM is new, and leaves the defaults alone") {
    Memory memory;
    Settings settings = default_settings();
    CHECK(Store(memory).load(settings) == Found::New);
    CHECK(same(settings, default_settings()));
}

TEST_CASE("what is saved comes back, many times over") {
    Memory memory;
    for (uint32_t k = 0; k < 20; ++k) {
        CHECK(save(memory, some_settings(k)));
        Settings settings;
        CHECK(Store(memory).load(settings) == Found::Ok);
        CHECK(same(settings, some_settings(k)));
    }
}

TEST_CASE("the serial number may wrap") {
    Memory memory;
    REQUIRE(save(memory, some_settings(0)));
    uint8_t* const record = &memory.bytes[Store::kFirstSlot];
    record[2] = record[3] = 0xFF;  // serial number 65535, and the CRC to it
    uint16_t crc = kCrcStart;
    for (int i = 1; i < Store::kRecord - 2; ++i) crc = crc16_next(crc, record[i]);
    record[Store::kRecord - 2] = static_cast<uint8_t>(crc >> 8);
    record[Store::kRecord - 1] = static_cast<uint8_t>(crc & 0xFF);
    for (uint32_t k = 1; k < 4; ++k) {
        REQUIRE(save(memory, some_settings(k)));
        Settings settings;
        CHECK(Store(memory).load(settings) == Found::Ok);
        CHECK(same(settings, some_settings(k)));
    }
}

TEST_CASE("power that fails in any byte of a save leaves the old settings or the new ones") {
    Memory fresh;
    REQUIRE(save(fresh, some_settings(1)));
    REQUIRE(save(fresh, some_settings(2)));
    Memory whole = fresh;
    whole.writes = 0;
    REQUIRE(save(whole, some_settings(3)));
    REQUIRE(whole.writes > 100);
    for (int cut = 1; cut <= whole.writes; ++cut) {
        for (const int torn : {-1, 0x00, 0xFF, 0x5E, 0xA7}) {
            Memory memory = fresh;
            memory.writes_left = cut;
            memory.torn = torn;
            save(memory, some_settings(3));
            memory.writes_left = -1;
            Settings settings = default_settings();
            const Found found = Store(memory).load(settings);
            const bool usable = found == Found::Ok || found == Found::Older;
            CAPTURE(cut);
            CAPTURE(torn);
            CHECK(usable);
            const bool old_or_new =
                same(settings, some_settings(2)) || same(settings, some_settings(3));
            CHECK(old_or_new);
            CHECK(save(memory, some_settings(4)));  // and the next save works
            CHECK(Store(memory).load(settings) != Found::Damaged);
            CHECK(same(settings, some_settings(4)));
        }
    }
}

TEST_CASE("a cut in the very first save leaves a new EEPROM") {
    for (int cut = 1; cut < 100; ++cut) {
        Memory memory;
        memory.writes_left = cut;
        save(memory, some_settings(1));
        Settings settings = default_settings();
        CHECK(Store(memory).load(settings) == Found::New);
        CHECK(same(settings, default_settings()));
    }
}

TEST_CASE("a byte that goes bad later costs one copy, two cost the settings, and both are told") {
    Memory memory;
    REQUIRE(save(memory, some_settings(1)));
    REQUIRE(save(memory, some_settings(2)));
    memory.bytes[Store::kFirstSlot + Store::kSlotStride + 20] ^= 0x10;
    Settings settings = default_settings();
    CHECK(Store(memory).load(settings) == Found::Older);
    CHECK(same(settings, some_settings(1)));
    memory.bytes[Store::kFirstSlot + 20] ^= 0x10;
    settings = default_settings();
    CHECK(Store(memory).load(settings) == Found::Damaged);
    CHECK(same(settings, default_settings()));
}

TEST_CASE("an EEPROM that does not keep a byte is found out") {
    struct Worn : Memory {
        void write(uint16_t address, uint8_t byte) override {
            Memory::write(address, address == Store::kFirstSlot + 9 ? 0x00 : byte);
        }
    };
    Worn worn;
    CHECK_FALSE(save(worn, some_settings(1)));
}

TEST_CASE("boot numbers count up through power loss, over the ring and over 65535") {
    Memory memory;
    uint16_t last = count_boot(memory);
    CHECK(last == 0);
    for (int k = 0; k < 70000; ++k) {
        const uint16_t now = count_boot(memory);
        if (now != static_cast<uint16_t>(last + 1)) REQUIRE(now == last + 1);
        last = now;
    }
}

TEST_CASE("a start that loses power while it counts does not spoil the count") {
    Memory memory;
    for (int k = 0; k < 1000; ++k) {
        const uint16_t told = count_boot(memory);
        memory.writes_left = k % 2 + 1;
        memory.torn = k % 3 ? -1 : 0x00;
        count_boot(memory);  // tells nobody
        memory.writes_left = -1;
        CHECK(count_boot(memory) != told);
    }
}

TEST_CASE("trims and limits in the units of the frame") {
    Settings settings = default_settings();
    const Trim trim = trim_of(settings, 2);
    CHECK(trim.centre_us == 1500);
    CHECK(trim.scale_q5_us_per_rad == 573 * 32);
    CHECK(std::fabs(trim.low_q14 / 16384.0 + 1.5707963) < 1e-4);
    CHECK(pulse_at(settings, 2, kHigh) == 2400);
    CHECK(pulse_at(settings, 2, kLow) == 600);
    settings.trim_u[2][kDir] = -1000000;
    CHECK(pulse_at(settings, 2, kHigh) == 600);
    const MotionLimits limits = limits_of(settings);
    const double degree = 3.14159265358979 / 180;
    CHECK(std::fabs(limits.angle_step_q30 / 1073741824.0 - 1.2 * degree) < 1e-8);
    CHECK(std::fabs(limits.pose_step_q30 / 1073741824.0 - 0.9 * degree) < 1e-8);
    CHECK(std::fabs(limits.servo_step_q14 / 16384.0 - 10 * degree) < 1e-4);
    CHECK(limits.rate_step == phase_step(100000));
}
