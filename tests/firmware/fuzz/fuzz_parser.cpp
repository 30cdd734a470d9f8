// libFuzzer target: any bytes through line reader, envelope and command parser, and what must hold
// then.
#include <cstdlib>
#include <cstring>

#include "command.h"
#include "crc16.h"
#include "fields.h"
#include "line_reader.h"

using namespace firmware;

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

void check_command(const Envelope& envelope) {
    Command command;
    const Refusal refusal = parse_command(envelope.body, envelope.length, command);
    require(std::memchr(refusal.field, 0, sizeof refusal.field) != nullptr);
    if (!refusal.none()) return;
    require(static_cast<uint8_t>(command.verb) < kVerbs);
    if (command.verb == Verb::Gait) {
        for (uint8_t i = 0; i < kGaitFieldCount; ++i) {
            require(in_range(gait_field(i), command.value_u[i]));
        }
    }
    if (command.verb == Verb::Pose) {
        for (int32_t angle : command.value_u) require(in_range(joint_angle_field(), angle));
    }
    if (command.verb == Verb::Set && !command.lists) {
        require(in_range(setting_field(command.field), command.value_u[0]));
    }
    if (command.verb == Verb::Trim && !command.lists) {
        require(command.joint < kJoints);
        require(in_range(trim_field(command.field), command.value_u[0]));
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    LineReader reader;
    for (size_t i = 0; i < size; ++i) {
        const LineReader::Event event = reader.push(data[i]);
        require(reader.length() <= LineReader::kCapacity);
        if (event == LineReader::kNothing) continue;
        Envelope envelope;
        if (event == LineReader::kLine &&
            check_line(reader.data(), reader.length(), envelope) == Error::None) {
            require(envelope.body >= reader.data());
            require(envelope.body + envelope.length <= reader.data() + reader.length());
            check_command(envelope);
        }
        reader.clear();
    }
    return 0;
}
