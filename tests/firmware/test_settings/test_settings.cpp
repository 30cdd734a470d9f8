// Settings: units, and EEPROM whose power fails at every byte of every save.
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

// A store that has looked for copies, as at a start.
struct Started : Store {
    explicit Started(Memory& memory, Settings& settings) : Store(memory) {
        Store::load(settings);
        end();
    }
    int end() {
        int bytes = 0;
        for (; busy() && bytes < 2000; ++bytes) step();
        REQUIRE_FALSE(busy());
        return bytes;
    }
};

LoadResult load(Memory& memory, Settings& settings) {
    return Started(memory, settings).load_result();
}

bool save(Memory& memory, Settings settings) {
    Settings before = default_settings();
    Started store(memory, before);
    store.save(settings);
    store.end();
    return store.good();
}

bool same(const Settings& a, const Settings& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

int32_t within(std::mt19937& random, const Field& field) {
    const double part = static_cast<double>(random()) / 4294967295.0;
    const double value_u = field.low_u + part * (static_cast<double>(field.high_u) - field.low_u);
    const int32_t rounded_u = static_cast<int32_t>(value_u);
    return field.is_integer ? rounded_u / 1000000 * 1000000 : rounded_u;
}

// Settings that could have been set.
Settings some_settings(uint32_t seed) {
    std::mt19937 random(seed);
    Settings settings = default_settings();
    for (uint8_t i = 0; i < kSettingCount; ++i) {
        settings.value_u[i] = within(random, setting_field(i));
    }
    for (auto& trim : settings.trim_u) {
        trim[kCentre] = 1400000000 + static_cast<int32_t>(random() % 200) * 1000000;
        trim[kScale] = 500000000 + static_cast<int32_t>(random() % 100) * 1000001;
        trim[kDir] = random() % 2 ? 1000000 : -1000000;
        trim[kLow] = -static_cast<int32_t>(random() % 80) * 1000001;
        trim[kHigh] = static_cast<int32_t>(random() % 80) * 1000001;
    }
    return settings;
}

// Give a copy the CRC of its bytes, for a number of joints.
void seal_copy(Memory& memory, uint8_t slot, uint8_t joints) {
    uint8_t* const record = &memory.bytes[Store::slot_address(slot)];
    const int end = Store::record_size(joints) - 2;
    uint16_t crc = kCrcStart;
    for (int i = 0; i < end; ++i) crc = crc16_next(crc, record[i]);
    record[end] = static_cast<uint8_t>(crc >> 8);
    record[end + 1] = static_cast<uint8_t>(crc & 0xFF);
}

}  // namespace

TEST_CASE("power that fails in any byte of a save leaves the old settings or the new ones") {
    Memory fresh;
    REQUIRE(save(fresh, some_settings(1)));
    REQUIRE(save(fresh, some_settings(2)));
    Memory whole = fresh;
    whole.writes = 0;
    REQUIRE(save(whole, some_settings(3)));
    REQUIRE(whole.writes > 100);
    Settings settings = default_settings();
    for (int cut = 1; cut <= whole.writes; ++cut) {
        Memory first;
        first.writes_left = cut / 2;  // in the very first save nothing is kept
        save(first, some_settings(1));
        settings = default_settings();
        CHECK(load(first, settings) == LoadResult::New);
        CHECK(same(settings, default_settings()));
        for (const int torn : {-1, 0x00, 0x01, 0x02, 0xFF, 0xA7}) {
            Memory memory = fresh;
            memory.writes_left = cut;
            memory.torn = torn;
            save(memory, some_settings(3));
            memory.writes_left = -1;
            settings = default_settings();
            const LoadResult result = load(memory, settings);
            const bool usable = result == LoadResult::Ok || result == LoadResult::Older;
            CAPTURE(cut);
            CAPTURE(torn);
            CHECK(usable);
            const bool old_or_new =
                same(settings, some_settings(2)) || same(settings, some_settings(3));
            CHECK(old_or_new);
            CHECK(save(memory, some_settings(4)));  // and the next save works
            CHECK(load(memory, settings) != LoadResult::Damaged);
            CHECK(same(settings, some_settings(4)));
        }
    }
}

TEST_CASE("a byte that goes bad later costs one copy, two cost the settings, and both are told") {
    Memory memory;
    REQUIRE(save(memory, some_settings(1)));
    REQUIRE(save(memory, some_settings(2)));
    memory.bytes[Store::slot_address(1) + 20] ^= 0x10;
    Settings settings = default_settings();
    CHECK(load(memory, settings) == LoadResult::Older);
    CHECK(same(settings, some_settings(1)));
    memory.bytes[Store::slot_address(0) + 20] ^= 0x10;
    settings = default_settings();
    CHECK(load(memory, settings) == LoadResult::Damaged);
    CHECK(same(settings, default_settings()));
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
    for (int k = 0; k < 1000; ++k) {  // a start that loses power while it counts tells nobody
        const uint16_t told = count_boot(memory);
        memory.writes_left = k % 2 + 1;
        memory.torn = k % 3 ? -1 : 0x00;
        count_boot(memory);
        memory.writes_left = -1;
        CHECK(count_boot(memory) != told);
    }
}

TEST_CASE("a copy of another layout is none, and is written over") {
    Memory memory;
    REQUIRE(save(memory, some_settings(1)));
    memory.bytes[Store::slot_address(0) + 1] = Store::kLayout - 1;
    Settings settings = default_settings();
    CHECK(load(memory, settings) == LoadResult::New);
    CHECK(same(settings, default_settings()));
    REQUIRE(save(memory, some_settings(2)));
    CHECK(load(memory, settings) == LoadResult::Ok);
}

TEST_CASE("a copy for another number of joints keeps what both have") {
    Memory memory;
    REQUIRE(save(memory, some_settings(3)));
    memory.bytes[Store::slot_address(0) + 2] = joint_count - 1;
    seal_copy(memory, 0, joint_count - 1);  // the last joint's trim goes, the CRC moves up
    Settings settings = default_settings();
    CHECK(load(memory, settings) == LoadResult::Migrated);
    Settings wanted = some_settings(3);
    for (int f = 0; f < kTrimFieldCount; ++f) {
        wanted.trim_u[joint_count - 1][f] = default_settings().trim_u[joint_count - 1][f];
    }
    CHECK(same(settings, wanted));
}
