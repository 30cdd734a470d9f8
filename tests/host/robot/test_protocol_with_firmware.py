"""Both ends of the wire on one table: the host reads what the firmware's own controller says."""

import random

from serpenoid._core import firmware
from serpenoid.robot.wire import protocol
from serpenoid.robot.wire.error_table import ERRORS

COMMANDS = ("hello", "gait 30 80 5", "status", "trim", "set", "help", "gait 95 0 1", "nonsense")


def test_one_table_one_protocol_one_crc():
    assert firmware.PROTOCOL == protocol.PROTOCOL
    assert {word: (n, cause, cure) for word, n, cause, cure in firmware.ERRORS} == ERRORS
    rng = random.Random(1)
    for length in range(200):
        text = "".join(chr(rng.randint(32, 126)) for _ in range(length))
        assert firmware.crc16(text.encode()) == protocol.crc(text)


def test_every_line_of_a_session_is_understood():
    board = firmware.Board()
    board.boot()
    board.run(0.5)
    for number, command in enumerate(COMMANDS, 1):
        board.write(protocol.seal(command, number))
        board.run(0.5)
    messages = [protocol.parse(line) for line in board.read().splitlines() if line]
    verdicts = [m for m in messages if isinstance(m, protocol.Verdict)]
    assert [(v.number, v.error) for v in verdicts] == [
        (1, ""),
        (2, ""),
        (3, ""),
        (4, ""),
        (5, ""),
        (6, ""),
        (7, "range"),
        (8, "command"),
    ]
    assert messages[-1].state == "gait"
    assert sum(isinstance(m, protocol.Hello) for m in messages) == 2
