// A line of text to a command: envelope (number, CRC) first, then words and numbers.
#pragma once

#include <stdint.h>

#include "error_codes.h"
#include "fields.h"
#include "gait.h"
#include "progmem.h"

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
    Hello,
    Bye,
    Ping,
    Help,
    Status,
    Gait,
    Pose,
    Stop,
    Idle,
    Set,
    Trim,
    Save,
    Load,
    Defaults
};
const uint8_t kVerbs = 14;

const uint8_t kMostGaitFields = kGaitFieldCount;
const uint8_t kMostValues = kJoints > kMostGaitFields ? kJoints : kMostGaitFields;

struct Command {
    Verb verb;
    bool lists;                    // `set` or `trim` without fields
    bool unattended, replaces;     // of `save`
    uint8_t joint;                 // of `trim`, from 0
    uint8_t field;                 // Setting or TrimField
    int32_t value_u[kMostValues];  // gait fields, joint angles, or the value of set and trim
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
