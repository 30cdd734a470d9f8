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
        int slices = 0;
        for (; busy() && slices < 2000; ++slices) step();
        REQUIRE_FALSE(busy());
        return slices;
    }
};

Found load(Memory& memory, Settings& settings) { return Started(memory, settings).found(); }

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
    return field.whole ? rounded_u / 1000000 * 1000000 : rounded_u;
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

// Give a copy the CRC that its bytes before `end` ask for.
void seal_copy(Memory& memory, uint8_t slot, int end = Store::kRecord - 2) {
    uint8_t* const record = &memory.bytes[Store::slot_at(slot)];
    uint16_t crc = kCrcStart;
    for (int i = 1; i < end; ++i) crc = crc16_next(crc, record[i]);
    record[end] = static_cast<uint8_t>(crc >> 8);
    record[end + 1] = static_cast<uint8_t>(crc & 0xFF);
}

}  // namespace

TEST_CASE("the serial number may wrap") {
    Memory memory;
    REQUIRE(save(memory, some_settings(0)));
    uint8_t* const record = &memory.bytes[Store::slot_at(0)];
    record[2] = record[3] = 0xFF;  // serial number 65535
    seal_copy(memory, 0);
    for (uint32_t k = 1; k < 4; ++k) {
        REQUIRE(save(memory, some_settings(k)));
        Settings settings = default_settings();
        CHECK(load(memory, settings) == Found::Ok);
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
            const Found found = load(memory, settings);
            const bool usable = found == Found::Ok || found == Found::Older;
            CAPTURE(cut);
            CAPTURE(torn);
            CHECK(usable);
            const bool old_or_new =
                same(settings, some_settings(2)) || same(settings, some_settings(3));
            CHECK(old_or_new);
            CHECK(save(memory, some_settings(4)));  // and the next save works
            CHECK(load(memory, settings) != Found::Damaged);
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
        CHECK(load(memory, settings) == Found::New);
        CHECK(same(settings, default_settings()));
    }
}

TEST_CASE("a byte that goes bad later costs one copy, two cost the settings, and both are told") {
    Memory memory;
    REQUIRE(save(memory, some_settings(1)));
    REQUIRE(save(memory, some_settings(2)));
    memory.bytes[Store::slot_at(1) + 20] ^= 0x10;
    Settings settings = default_settings();
    CHECK(load(memory, settings) == Found::Older);
    CHECK(same(settings, some_settings(1)));
    memory.bytes[Store::slot_at(0) + 20] ^= 0x10;
    settings = default_settings();
    CHECK(load(memory, settings) == Found::Damaged);
    CHECK(same(settings, default_settings()));
}

TEST_CASE("an EEPROM that does not keep a byte is found out") {
    struct Worn : Memory {
        void write(uint16_t address, uint8_t byte) override {
            Memory::write(address, address == Store::slot_at(0) + 9 ? 0x00 : byte);
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

TEST_CASE("a copy by a firmware of fewer settings is taken over, and saved anew") {
    Memory memory;
    Settings old = some_settings(7);
    REQUIRE(save(memory, old));
    uint8_t* const record = &memory.bytes[Store::slot_at(0)];
    uint8_t* const last = record + Store::kHead + 4 * --record[4];
    std::memmove(last, last + 4, sizeof old.trim_u);
    seal_copy(memory, 0, Store::kRecord - 6);
    old.value_u[kSettingCount - 1] = setting_field(kSettingCount - 1).default_u;
    Settings settings = default_settings();
    CHECK(load(memory, settings) == Found::Migrated);
    CHECK(same(settings, old));
    for (int cut = 1; cut <= 160; ++cut) {  // it is not lost while it is being saved anew
        Memory half = memory;
        half.writes_left = cut;
        save(half, settings);
        half.writes_left = -1;
        Settings found = default_settings();
        load(half, found);
        REQUIRE(same(found, settings));
    }
    REQUIRE(save(memory, settings));
    CHECK(load(memory, settings) == Found::Ok);
}

TEST_CASE("a copy of the first layout is none, and is written over") {
    Memory memory;
    REQUIRE(save(memory, some_settings(1)));
    memory.bytes[Store::slot_at(0) + 1] = 1;
    Settings settings = default_settings();
    CHECK(load(memory, settings) == Found::New);
    CHECK(same(settings, default_settings()));
    REQUIRE(save(memory, some_settings(2)));
    CHECK(load(memory, settings) == Found::Ok);
}

TEST_CASE("a copy for another number of joints keeps what both have") {
    Memory memory;
    REQUIRE(save(memory, some_settings(3)));
    uint8_t* const record = &memory.bytes[Store::slot_at(0)];
    record[5] = kJoints - 1;  // the last joint's trim goes, the CRC moves up
    seal_copy(memory, 0, Store::kRecord - 2 - 4 * kTrimFieldCount);
    Settings settings = default_settings();
    CHECK(load(memory, settings) == Found::Migrated);
    Settings wanted = some_settings(3);
    for (int f = 0; f < kTrimFieldCount; ++f) {
        wanted.trim_u[kJoints - 1][f] = default_settings().trim_u[kJoints - 1][f];
    }
    CHECK(same(settings, wanted));
}

TEST_CASE("a whole copy with a value out of its range is refused like a damaged one") {
    for (int value = 0; value < kSettingCount + kTrimFieldCount; ++value) {
        Memory memory;
        REQUIRE(save(memory, some_settings(1)));
        REQUIRE(save(memory, some_settings(2)));
        uint8_t* const bytes = &memory.bytes[Store::slot_at(1) + Store::kHead + 4 * value];
        bytes[3] = 0x7F;  // above two thousand millions
        seal_copy(memory, 1);
        Settings settings = default_settings();
        CAPTURE(value);
        CHECK(load(memory, settings) == Found::Older);
        CHECK(same(settings, some_settings(1)));
    }
    Memory memory;  // each in its range, but together beyond the pulses of a servo
    Settings wide = default_settings();
    wide.trim_u[0][kScale] = 1200000000;
    REQUIRE(save(memory, wide));
    Settings settings = default_settings();
    CHECK(load(memory, settings) == Found::Damaged);
    CHECK(same(settings, default_settings()));
}

TEST_CASE("a copy of a newer firmware is told, and lost only when asked for") {
    const auto newer_layout = [](Memory& memory) {
        memory.bytes[Store::slot_at(0) + 1] = Store::kLayout + 1;
    };
    const auto more_settings = [](Memory& memory) {
        uint8_t* const record = &memory.bytes[Store::slot_at(0)];
        record[4] = kSettingCount + 1;  // the first trim is read as a setting, the rest moves down
        record[5] = kJoints - 1;
        // what is now each joint's centre was its scale: give all fields values that can be
        for (int j = 0; j < kJoints - 1; ++j) {
            const int32_t fine[] = {1500000000, 573000000, 1000000, -90000000, 90000000};
            std::memcpy(record + Store::kHead + 4 * (kSettingCount + 1 + j * kTrimFieldCount), fine,
                        sizeof fine);
        }
        seal_copy(memory, 0, Store::kRecord - 2 - 4 * (kTrimFieldCount - 1));
    };
    Memory first;
    REQUIRE(save(first, some_settings(1)));
    for (const bool layout : {true, false}) {
        Memory memory = first;
        layout ? newer_layout(memory) : more_settings(memory);
        Settings settings = default_settings();
        Started store(memory, settings);
        CHECK(store.found() == Found::Newer);
        CHECK(store.newer());
        CHECK(store.loaded() == !layout);
        Settings wanted = some_settings(2);
        store.save(wanted);
        store.end();
        CHECK(store.good());
        CHECK_FALSE(store.newer());
        CHECK(load(memory, settings) == Found::Ok);
        CHECK(same(settings, wanted));
    }
    Memory memory = first;  // an older copy of ours beside it is used
    REQUIRE(save(memory, some_settings(2)));
    newer_layout(memory);
    Settings settings = default_settings();
    CHECK(load(memory, settings) == Found::Newer);
    CHECK(same(settings, some_settings(2)));
}

TEST_CASE("no slice of a load or save reads or writes more than a frame may wait") {
    struct Counting : Memory {
        int reads = 0;
        uint8_t read(uint16_t address) override {
            ++reads;
            return Memory::read(address);
        }
    };
    Counting memory;
    REQUIRE(save(memory, some_settings(1)));
    REQUIRE(save(memory, some_settings(2)));
    Settings settings = default_settings();
    Store store(memory);
    for (const bool saves : {false, true}) {
        saves ? store.save(settings) : store.load(settings);
        while (store.busy()) {
            memory.reads = memory.writes = 0;
            store.step();
            CHECK(memory.reads <= 60);  // some 5 us each on a Uno
            CHECK(memory.writes <= 1);
        }
    }
}
