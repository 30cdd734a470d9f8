// Parse a line into a command: first its envelope (number, CRC), then words and numbers.
#pragma once

#include <stdint.h>

#include "error_codes.h"
#include "fields.h"
#include "gait.h"
#include "progmem.h"

// The table of verbs: X(identifier, word, minimum and maximum number of fields, help after the
// word).
#define FIRMWARE_VERBS(X)                                                  \
    X(Hello, "hello", 0, 0, " - greet; with CRC, open a session")          \
    X(Bye, "bye", 0, 0, " - close it")                                     \
    X(Ping, "ping", 0, 0, " - the host is alive")                          \
    X(Help, "help", 0, 0, "")                                              \
    X(Status, "status", 0, 0, "")                                          \
    X(Gait, "gait", 3, 4, " ALPHA BETA OMEGA [OFFSET] - deg, rad/s")       \
    X(Pose, "pose", 1, kMaxJoints, " straight [OFFSET] | J1 J2 ... - deg") \
    X(Stop, "stop", 0, 0, " - freeze and hold; so does any !")             \
    X(Idle, "idle", 0, 0, " - end all pulses")                             \
    X(Set, "set", 0, 2, " [NAME VALUE]")                                   \
    X(Trim, "trim", 0, 3, " [J FIELD VALUE]")                              \
    X(Save, "save", 0, 1, " [unattended]")                                 \
    X(Load, "load", 0, 0, " - from EEPROM")                                \
    X(Defaults, "defaults", 0, 0, "")

namespace firmware {

// The body of a line, and the number and CRC around it.
struct Envelope {
    const char* body;
    uint8_t length;
    bool has_crc, has_number;
    uint16_t number;
};

// Split `[#NUMBER ]BODY[ *CRC]`. Returns Error::Crc or Error::Sequence if one is present but wrong.
Error check_line(const char* line, uint8_t length, Envelope& envelope);

// Whether a line ends in `stop`, which the receive interrupt has already recognised.
bool ends_in_stop(const char* line, uint8_t length);
// Whether a whole line is `bye` and nothing else.
bool is_bare_bye(const char* line, uint8_t length);

enum class Verb : uint8_t {
#define FIRMWARE_VERB_ID(id, word, min_fields, max_fields, help) id,
    FIRMWARE_VERBS(FIRMWARE_VERB_ID)
#undef FIRMWARE_VERB_ID
};
#define FIRMWARE_VERB_COUNT(id, word, min_fields, max_fields, help) +1
const uint8_t kVerbs = FIRMWARE_VERBS(FIRMWARE_VERB_COUNT);
#undef FIRMWARE_VERB_COUNT

const uint8_t kMaxGaitFields = kGaitFieldCount;
const uint8_t kMaxValues = kMaxJoints > kMaxGaitFields ? kMaxJoints : kMaxGaitFields;

struct Command {
    Verb verb;
    bool lists;                   // `set` or `trim` without fields: list all values
    bool unattended;              // `save unattended`
    uint8_t joint;                // joint of `trim`, from 0
    uint8_t field;                // Setting or TrimField
    int32_t value_u[kMaxValues];  // gait fields, joint angles, or the value of `set` or `trim`
};

// The reason why a command is refused; for Error::Range and Error::Speed also field and limits.
struct Refusal {
    Error error;
    char field[12];  // empty for other errors
    int32_t value_u, low_u, high_u;

    explicit Refusal(Error e = Error::None) : error(e), field(), value_u(0), low_u(0), high_u(0) {}
    Refusal(Error e, const char* name, int32_t value, int32_t low, int32_t high);
    bool none() const { return error == Error::None; }
};

// Parse the body of a line and check the limits of fields.h. The controller checks those that
// depend on the state of the robot.
OWN_FRAME Refusal parse_command(const char* body, uint8_t length, Command& command);

// `help:` text of a verb, in flash.
const char* verb_help(uint8_t verb);

}  // namespace firmware
