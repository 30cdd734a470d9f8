// Lines, CRC, numbers, commands, tables: what is taken, what is refused and why.
#include <cstring>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "command.h"
#include "doctest_main.h"
#include "fields.h"
#include "line_reader.h"
#include "lines.h"
#include "telemetry.h"

using namespace firmware;

namespace {

Refusal parse(const std::string& body, Command& command) {
    return parse_command(body.data(), static_cast<uint8_t>(body.size()), command);
}

std::vector<int> joints(const Command& command) {
    return std::vector<int>(command.value_u, command.value_u + kJoints);
}

Error error_of(const std::string& body) {
    Command command;
    return parse(body, command).error;
}

Error envelope_of(const std::string& line, Envelope& envelope) {
    return check_line(line.data(), static_cast<uint8_t>(line.size()), envelope);
}

std::string unended(const std::string& line) { return line.substr(0, line.size() - 1); }

// What a line says, its CRC and end cut off.
std::string written(Output& out) {
    out.finish();
    const std::string line = taken(out);
    return line.substr(0, line.size() - 7);
}

}  // namespace

TEST_CASE("every flip of one or two bits in a line is seen") {
    const std::string good = unended(sealed("#12 gait 30 80 5"));
    Envelope envelope;
    REQUIRE(envelope_of(good, envelope) == Error::None);
    const size_t bits = good.size() * 8;
    for (size_t a = 0; a < bits; ++a) {
        for (size_t b = a; b < bits; ++b) {
            std::string bad = good;
            bad[a / 8] = static_cast<char>(bad[a / 8] ^ (1 << (a % 8)));
            if (b != a) bad[b / 8] = static_cast<char>(bad[b / 8] ^ (1 << (b % 8)));
            const Error error = envelope_of(bad, envelope);
            const bool taken = error == Error::None && envelope.has_crc && envelope.has_number;
            CHECK_FALSE(taken);
        }
    }
}

TEST_CASE("an envelope is a number, a body and a CRC, the first and the last optional") {
    Envelope e;
    CHECK(envelope_of("stop", e) == Error::None);
    CHECK(!e.has_crc);
    CHECK(!e.has_number);
    CHECK(envelope_of("#65535 stop", e) == Error::None);
    CHECK(e.number == 65535);
    CHECK(std::string(e.body, e.length) == "stop");
    CHECK(envelope_of("#7 stop *1021", e) == Error::None);
    CHECK(e.has_crc);
    CHECK(envelope_of("#7 stop *1022", e) == Error::Crc);
    for (const char* bad :
         {"#65536 stop", "#", "# stop", "#1", "#x stop", "#-1 stop", "#123456 x"}) {
        CHECK(envelope_of(bad, e) == Error::Sequence);
    }
}

TEST_CASE("numbers are millionths, exactly, or nothing") {
    Command c;
    for (const auto& pair :
         {std::make_pair("30", 30000000), std::make_pair("0.000001", 1),
          std::make_pair("89.999999", 89999999), std::make_pair("00.5", 500000)}) {
        CHECK(parse(std::string("gait ") + pair.first + " -80 5", c).none());
        CHECK(c.value_u[kAlpha] == pair.second);
        CHECK(c.value_u[kBeta] == -80000000);
    }
    for (const char* bad : {"1e1", "+1", "", ".", "1.", ".5", "-", "--1", "0x1", "1,5", "nan",
                            "inf", "0.0000001", "2147.483648", "99999999999", "1-", "1.2.3"}) {
        const Error error = error_of(std::string("gait 30 80 ") + bad);
        const bool refused = error == Error::Number || error == Error::Arguments;
        CAPTURE(bad);
        CHECK(refused);
    }
}

TEST_CASE("limits are inclusive and a refusal names them") {
    Command c;
    CHECK(parse("gait 0 -180 0.01 -90", c).none());
    CHECK(parse("gait 90 180 30 90", c).none());
    const Refusal refusal = parse("gait 90.000001 80 5", c);
    CHECK(refusal.error == Error::Range);
    CHECK(std::string(refusal.field) == "alpha");
    CHECK(refusal.value_u == 90000001);
    CHECK(refusal.high_u == 90000000);
    CHECK(error_of("gait 30 80 0") == Error::Range);
    CHECK(error_of("gait 30 80 -5") == Error::Range);
    CHECK(error_of("pose 0 0 0 0 115") == Error::Range);
    CHECK(error_of("trim 1 dir 0") == Error::Range);
    CHECK(parse("set silence 0.05", c).none());  // the controller knows this board's limits
}

TEST_CASE("commands") {
    Command c;
    CHECK(parse("pose straight 2.25", c).none());
    CHECK(joints(c) == std::vector<int>(5, 2250000));
    CHECK(parse("pose straight 90.1", c).error == Error::Range);
    CHECK(parse("pose straight", c).none());
    CHECK(parse("pose 1 2 3 4 5", c).none());
    CHECK(c.value_u[3] == 4000000);
    CHECK(parse("  stop  ", c).none());
    CHECK(c.verb == Verb::Stop);
    CHECK(parse("set silence off", c).none());
    CHECK(c.value_u[0] == 0);
    CHECK(parse("set limp off", c).none());
    CHECK(c.value_u[0] == 0);
    CHECK(parse("save", c).none());
    CHECK_FALSE(c.unattended);
    CHECK(parse("save unattended", c).none());
    CHECK(c.unattended);
    CHECK_FALSE(c.replaces);
    CHECK(parse("save replace unattended", c).none());
    CHECK(c.unattended);
    CHECK(c.replaces);
    CHECK(parse("trim 5 scale 600.5", c).none());
    CHECK(c.joint == 4);
    CHECK(c.field == kScale);
    CHECK(parse("trim", c).none());
    CHECK(c.lists);
}

TEST_CASE("what is not a command is refused for the right reason") {
    CHECK(error_of("") == Error::Command);
    CHECK(error_of("Stop") == Error::Command);
    CHECK(error_of("gai 1 2 3") == Error::Command);
    CHECK(error_of("gaits 1 2 3") == Error::Command);
    CHECK(error_of("gait 1 2") == Error::Arguments);
    CHECK(error_of("gait 1 2 3 4 5") == Error::Arguments);
    CHECK(error_of("pose 1 2 3 4 5 6") == Error::Arguments);
    CHECK(error_of("pose 1 2 3 4 5 6 7 8 9") == Error::Arguments);
    CHECK(error_of("pose straight 1 2") == Error::Arguments);
    CHECK(error_of("pose bent 7.5") == Error::Number);
    CHECK(error_of("pose straight x") == Error::Number);
    CHECK(error_of("ping 1") == Error::Arguments);
    CHECK(error_of("save now") == Error::Arguments);
    CHECK(error_of("set every off") == Error::Number);
    CHECK(error_of("set every 1.5") == Error::Number);
    CHECK(error_of("set silenc 1") == Error::Name);
    CHECK(error_of("set silence") == Error::Arguments);
    CHECK(error_of("trim 0 centre 1500") == Error::Name);
    CHECK(error_of("trim 6 centre 1500") == Error::Name);
    CHECK(error_of("trim 1.5 centre 1500") == Error::Name);
    CHECK(error_of("trim 1 center 1500") == Error::Name);
}

TEST_CASE("lines end with LF, CR or both; empty ones do not count") {
    LineReader reader;
    std::vector<std::string> lines;
    for (char c : std::string("\r\n\nstop\r\nping\n\rhelp\r")) {
        if (reader.push(static_cast<uint8_t>(c)) != LineReader::kLine) continue;
        lines.push_back(std::string(reader.data(), reader.length()));
        reader.clear();
    }
    CHECK(lines == std::vector<std::string>{"stop", "ping", "help"});
}

TEST_CASE("80 bytes are a line, 81 are not; a fault is told once, at the line's end") {
    for (const size_t length : {80u, 81u, 300u}) {
        LineReader reader;
        for (size_t i = 0; i < length; ++i) CHECK(reader.push('a') == LineReader::kNothing);
        CHECK(reader.push('\n') == (length <= 80 ? LineReader::kLine : LineReader::kOverlong));
    }
    for (const int code : {0x00, 0x07, 0x1F, 0x7F, 0x80, 0xFF}) {
        const uint8_t byte = static_cast<uint8_t>(code);
        LineReader reader;
        CHECK(reader.push(byte) == LineReader::kNothing);
        CHECK(reader.push('\n') == LineReader::kGarbled);
    }
}

TEST_CASE("numbers are written as they are read") {
    std::mt19937 random(5);
    for (int k = 0; k < 20000; ++k) {
        const int32_t value = static_cast<int32_t>(random()) >> (random() % 32);
        if (value == INT32_MIN) continue;  // not a wire value
        Output out;
        out.begin().put_unsigned(static_cast<uint32_t>(value));
        CHECK(written(out) == std::to_string(static_cast<uint32_t>(value)));
        out.begin().put_micro(value);
        const std::string said = written(out);
        CHECK(std::lround(std::stod(said) * 1e6) == value);
        CHECK(said.find_last_of('.') != said.size() - 1);
    }
    Output out;
    out.begin().put_fixed(-325, 2).put(' ').put_fixed(5, 3).put(' ').put_fixed(0, 2);
    CHECK(written(out) == "-3.25 0.005 0.00");
    out.begin().put_micro(0);
    CHECK(written(out) == "0");
}

TEST_CASE("the longest telemetry line fits, and is as long as PROTOCOL.md says") {
    Frame frame = {0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu, {},      {},
                   65535,       4294967,     kJoints,     "safing"};
    for (uint8_t i = 0; i < kJoints; ++i) {
        frame.setpoint_q14[i] = -32767;
        frame.pulse_us[i] = 2500;
    }
    Output out;
    CHECK(write_telemetry(out, frame));
    const std::string line = taken(out);
    CHECK(line.back() == '\n');
    CHECK(line.size() == (kJoints == 5 ? 182 : line.size()));
}

TEST_CASE("errors have distinct words and numbers, and no text that a plotter would draw") {
    std::set<std::string> words;
    for (uint8_t n = 1; n <= 18; ++n) {
        const ErrorText text = error_text(static_cast<Error>(n));
        CHECK(words.insert(text.word).second);
        for (const char* part : {text.word, text.cause, text.cure}) {
            CHECK(std::strlen(part) > 0);
            CHECK(std::strchr(part, ':') == nullptr);
        }
        // "err: #65535 " + word + " again" + field and limits + texts + CRC within the queue.
        CHECK(12 + std::strlen(text.word) + std::strlen(text.cause) + std::strlen(text.cure) < 170);
    }
}
