// The table of errors, with causes and cures, used by the board and by the host.
//
// X(identifier, number, word on the wire, cause, cure). No text may contain `word:value`, because
// serial plotters would plot it.
#pragma once

#include <stdint.h>

#define FIRMWARE_ERRORS(X)                                                                       \
    X(Crc, 1, "crc", "the line was damaged on the way", "send it again; check cable and ground") \
    X(NoCrc, 2, "nocrc", "a session is open and the line has no CRC",                            \
      "let the host finish, type bye, or press reset")                                           \
    X(Garbled, 3, "garbled", "bytes that are not printable ASCII", "check the baud rate")        \
    X(Overlong, 4, "overlong", "the line is too long", "send one command a line")                \
    X(Sequence, 5, "sequence", "the number is missing, unreadable or older than the last",       \
      "count up by one from hello")                                                              \
    X(Command, 6, "command", "no such command", "type help")                                     \
    X(Arguments, 7, "arguments", "too few or too many fields", "type help")                      \
    X(Number, 8, "number", "a field is not a number this field can hold",                        \
      "digits, a point and up to 6 decimals")                                                    \
    X(Name, 9, "name", "no such setting, field or joint", "type set or trim for the list")       \
    X(Range, 10, "range", "the value is outside its limits", "send one inside")                  \
    X(Speed, 11, "speed", "amplitude times rate is faster than the servos may move",             \
      "lower one, or raise servo_speed")                                                         \
    X(Motion, 12, "motion", "not while the robot moves", "send stop first")                      \
    X(Attached, 13, "attached", "not while the servos are powered", "send idle first")           \
    X(Saving, 14, "saving", "settings are being saved or loaded", "wait for that verdict")       \
    X(Eeprom, 15, "eeprom", "what was read back is not what was written",                        \
      "save again; the EEPROM may be worn")                                                      \
    X(Empty, 16, "empty", "nothing whole is saved", "save first")                                \
    X(Stopped, 17, "stopped", "a stop came after this line, before its turn",                    \
      "send it again if still wanted")                                                           \
    X(Unattended, 18, "unattended", "with silence off nothing stops a robot left alone",         \
      "set silence, or send save unattended")                                                    \
    X(Output, 19, "output", "the servo driver does not answer", "check its power and its two wires")

namespace firmware {

enum class Error : uint8_t {
    None = 0,
#define FIRMWARE_ERROR_ID(id, number, word, cause, cure) id = number,
    FIRMWARE_ERRORS(FIRMWARE_ERROR_ID)
#undef FIRMWARE_ERROR_ID
};

// Texts of an error, in flash.
struct ErrorText {
    const char *word, *cause, *cure;
};
ErrorText error_text(Error error);

}  // namespace firmware
