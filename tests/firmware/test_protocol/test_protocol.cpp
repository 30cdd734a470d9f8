// CRC, numbers and telemetry of the protocol. tests/golden/make_dialogue.py tests whole commands.
#include <random>
#include <string>

#include "command.h"
#include "doctest_main.h"
#include "lines.h"
#include "telemetry.h"

using namespace firmware;

namespace {

Error envelope_of(const std::string& line, Envelope& envelope) {
    return check_line(line.data(), static_cast<uint8_t>(line.size()), envelope);
}

std::string without_end(const std::string& line) { return line.substr(0, line.size() - 1); }

// The body of a line, without its CRC and line end.
std::string body_of(Output& out) {
    out.finish();
    const std::string line = taken(out);
    return line.substr(0, line.size() - 7);
}

}  // namespace

TEST_CASE("a line with one or two wrong bits is refused") {
    const std::string good = without_end(sealed("#12 gait 30 80 5"));
    Envelope envelope;
    REQUIRE(envelope_of(good, envelope) == Error::None);
    const size_t bits = good.size() * 8;
    for (size_t a = 0; a < bits; ++a) {
        for (size_t b = a; b < bits; ++b) {
            std::string bad = good;
            bad[a / 8] = static_cast<char>(bad[a / 8] ^ (1 << (a % 8)));
            if (b != a) bad[b / 8] = static_cast<char>(bad[b / 8] ^ (1 << (b % 8)));
            const Error error = envelope_of(bad, envelope);
            const bool accepted = error == Error::None && envelope.has_crc && envelope.has_number;
            CHECK_FALSE(accepted);
        }
    }
}

TEST_CASE("numbers are written so that reading gives them back") {
    std::mt19937 random(5);
    for (int k = 0; k < 20000; ++k) {
        const int32_t value = static_cast<int32_t>(random()) >> (random() % 32);
        if (value == INT32_MIN) continue;  // no value of the protocol
        Output out;
        out.begin().put_unsigned(static_cast<uint32_t>(value));
        CHECK(body_of(out) == std::to_string(static_cast<uint32_t>(value)));
        out.begin().put_micro(value);
        const std::string text = body_of(out);
        CHECK(std::lround(std::stod(text) * 1e6) == value);
        CHECK(text.find_last_of('.') != text.size() - 1);
    }
    Output out;
    out.begin().put_fixed(-325, 2).put(' ').put_fixed(5, 3).put(' ').put_fixed(0, 2);
    CHECK(body_of(out) == "-3.25 0.005 0.00");
    out.begin().put_micro(0);
    CHECK(body_of(out) == "0");
}

TEST_CASE("the longest telemetry line fits, and is as long as PROTOCOL.md says") {
    Frame frame = {0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu, {},      {},
                   65535,       4294967,     joint_count, "safing"};
    for (uint8_t i = 0; i < joint_count; ++i) {
        frame.setpoint_q14[i] = -32767;
        frame.pulse_us[i] = 2500;
    }
    Output out;
    CHECK(write_telemetry(out, frame));
    const std::string line = taken(out);
    CHECK(line.back() == '\n');
    CHECK(line.size() == (joint_count == 5 ? 182 : line.size()));
}
