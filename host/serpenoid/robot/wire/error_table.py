"""Why the board refuses a line: the host's copy of firmware/lib/protocol/error_codes.h."""

from __future__ import annotations

from typing import NamedTuple


class ErrorText(NamedTuple):
    """One row of the table: number, what happened, what to do about it."""

    number: int
    cause: str
    cure: str


ERRORS: dict[str, ErrorText] = {
    "crc": ErrorText(
        1,
        "the line was damaged on the way",
        "send it again; if it persists, shorten the cable or check its ground",
    ),
    "nocrc": ErrorText(
        2,
        "a session is open and the line has no CRC",
        "let the host finish, send bye, or press reset",
    ),
    "garbled": ErrorText(
        3,
        "bytes that are not printable ASCII, or a line never finished",
        "check the baud rate",
    ),
    "overlong": ErrorText(
        4,
        "the line is longer than 80 bytes",
        "send one command a line",
    ),
    "sequence": ErrorText(
        5,
        "the number is missing, unreadable or older than the last",
        "count up by one from hello",
    ),
    "command": ErrorText(
        6,
        "no such command",
        "type help",
    ),
    "arguments": ErrorText(
        7,
        "too few or too many fields",
        "type help",
    ),
    "number": ErrorText(
        8,
        "a field is not a number this field can hold",
        "digits, a point and up to 6 decimals",
    ),
    "name": ErrorText(
        9,
        "no such setting, field or joint",
        "type set or trim for the list",
    ),
    "range": ErrorText(
        10,
        "the value is outside its limits",
        "send one inside",
    ),
    "speed": ErrorText(
        11,
        "amplitude times rate is faster than the servos may move",
        "lower one, or raise servo_speed",
    ),
    "motion": ErrorText(
        12,
        "not while the robot moves",
        "send stop first",
    ),
    "attached": ErrorText(
        13,
        "not while the servos are powered",
        "send idle first",
    ),
    "saving": ErrorText(
        14,
        "settings are being saved",
        "wait for the verdict of save",
    ),
    "eeprom": ErrorText(
        15,
        "what was read back is not what was written",
        "save again; if it persists, the EEPROM is worn",
    ),
    "empty": ErrorText(
        16,
        "nothing whole is saved",
        "save first",
    ),
}
