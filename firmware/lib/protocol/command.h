// A line of text to a command: envelope (number, CRC) first, then words and numbers.
#pragma once

#include <stdint.h>

#include "error_codes.h"
#include "fields.h"
#include "gait.h"
#include "progmem.h"

// X(identifier, word, fewest fields, most fields, help behind the word): the one table of verbs.
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

// What check_line finds around the body of a line.
struct Envelope {
    const char* body;
    uint8_t length;
    bool has_crc, has_number;
    uint16_t number;
};

// Split `[#NUMBER ]BODY[ *CRC]`. Returns Crc or Sequence if either is there and wrong.
Error check_line(const char* line, uint8_t length, Envelope& envelope);

// Whether a line ends in `stop`, which the receive interrupt has seen already.
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
    bool lists;                   // `set` or `trim` without fields
    bool unattended;              // of `save`
    uint8_t joint;                // of `trim`, from 0
    uint8_t field;                // Setting or TrimField
    int32_t value_u[kMaxValues];  // gait fields, joint angles, or the value of set and trim
};

// Why a command is refused; with Range and Speed, which field and what its limits are.
struct Refusal {
    Error error;
    char field[12];  // empty if there is no more to say
    int32_t value_u, low_u, high_u;

    explicit Refusal(Error e = Error::None) : error(e), field(), value_u(0), low_u(0), high_u(0) {}
    Refusal(Error e, const char* name, int32_t value, int32_t low, int32_t high);
    bool none() const { return error == Error::None; }
};

// Understand a body. The limits of fields.h are enforced here; those that depend on the state of
// the robot are the controller's.
OWN_FRAME Refusal parse_command(const char* body, uint8_t length, Command& command);

// `help:` text of a verb, in flash.
const char* verb_help(uint8_t verb);

}  // namespace firmware
