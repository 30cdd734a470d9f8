"""One conversation: the board in the package, the real ELF and the host's reading agree on it."""

from __future__ import annotations

import math
import re

import pytest
from golden import dialogue, make_dialogue
from serpenoid._core import firmware
from serpenoid.robot.wire import protocol
from serpenoid.robot.wire.protocol import ERRORS


def test_the_file_is_what_its_script_writes() -> None:
    assert make_dialogue.dialogue_text() == dialogue.PATH.read_text()


def test_the_controller_says_it_byte_for_byte() -> None:
    board = firmware.Board()
    board.boot()
    count = dialogue.play(board.write, board.run, board.read, timed=True)
    assert count == sum(mark == "<" for mark, _ in dialogue.steps())


@pytest.mark.avr
def test_the_elf_says_it_byte_for_byte(start) -> None:
    board = start("uno")

    def as_uno(line: bytes) -> bytes:
        body = line.rpartition(b" *")[0].replace(b"board=virtual", b"board=uno")
        body = body.replace(b"low=3 high=20", b"low=15 high=20")  # of a frame, at its pins
        return body + f" *{protocol.crc(body.decode()):04X}".encode()

    count = dialogue.play(board.send, board.run, board.read, timed=False, renamed=as_uno)
    assert count == sum(mark == "<" and text[:2] != b"t:" for mark, text in dialogue.steps())


def test_the_host_seals_the_same_bytes() -> None:
    numbered = re.compile(rb"#(\d+) (.*) \*(?!0000)[0-9A-F]{4}\n")
    matches = (numbered.fullmatch(text) for _, text in dialogue.steps())
    lines = [line for line in matches if line and int(line[1]) < 65536]
    assert len(lines) > 30
    for line in lines:
        assert protocol.seal(line[2].decode(), int(line[1])) == line[0]


def spoken(message: protocol.Message) -> str:
    """Return the line of the board that a message was read from."""
    match message:
        case protocol.Hello():
            return (
                f"hello: serpenoid fw={message.firmware} protocol={message.protocol} board="
                f"{message.board} joints={message.joints} frame_us={message.frame_us} "
                f"boot={message.boot} reset={message.reset} settings={message.settings} "
                f"silence={message.silence_s:g}"
            )
        case protocol.Verdict():
            head = "ok" if message.accepted else "err"
            words = [f"{head}: #{message.mark}", message.error, "again" * message.is_repeat]
            return " ".join(word for word in [*words, message.detail] if word)
        case protocol.Telemetry():
            joints = enumerate(map(math.degrees, message.setpoint_rad), 1)
            return (
                f"t:{message.frame} {' '.join(f'j{j}:{angle:.2f}' for j, angle in joints)} "
                f"board_us={message.board_us} ph={math.degrees(message.phase_rad):.3f} "
                f"p={','.join(map(str, message.pulse_us))} exec_us={message.exec_us} "
                f"late_us={message.late_us} clipped={message.clipped} st={message.state}"
            )
        case protocol.Data():
            return f"{message.word}: {message.text}"


def test_the_host_understands_every_word() -> None:
    messages = [protocol.parse(text) for mark, text in dialogue.steps() if mark == "<"]
    lines = [protocol.unseal(text) for mark, text in dialogue.steps() if mark == "<"]
    assert [spoken(message) for message in messages] == lines
    verdicts = [message for message in messages if isinstance(message, protocol.Verdict)]
    assert {type(message) for message in messages} == set(protocol.Message.__args__)
    # An EEPROM that does not keep what is written is not to be had on a simulated board, and
    # among which lines a stop's verdict comes depends on the clock; the host alone knows bends,
    # no firmware is newer than this one, and the virtual board has servos.
    unsaid = {"eeprom", "stopped", "unbalanced", "newer", "output"}
    assert {v.error for v in verdicts if v.error} == set(ERRORS) - unsaid
