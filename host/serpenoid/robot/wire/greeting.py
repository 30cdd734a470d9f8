"""Open a session with a board: wait for its greeting, ask for it, and check its protocol."""

from __future__ import annotations

from ...base.errors import NoAnswer, ProtocolMismatch
from .dialogue import TIMES, Dialogue
from .link import BAUD
from .protocol import PROTOCOL

FLASH = "`serpenoid flash --port {port}`"


def greet(talk: Dialogue, timeout_s: float) -> None:
    """Open a session with a board; raises ProtocolMismatch or NoAnswer.

    timeout_s: time to listen. Time in which this process was suspended does not count.
    """
    now_s = talk.link.now_s
    # A board greets unasked within 2 s after the port's opening has reset it.
    begun_s, boot_s = now_s(), min(2.0, timeout_s / 2)
    talk.wait(lambda: talk.inbox.heard, begun_s + boot_s)
    left_s = timeout_s - min(now_s() - begun_s, boot_s)
    opened = False
    while not opened and left_s > TIMES.min_patience_s:
        _check_protocol(talk)
        asked_s, ask_s = now_s(), min(0.5, left_s)
        opened = talk.open_session(ask_s)
        left_s -= min(now_s() - asked_s, ask_s)
    _check_protocol(talk)
    if not opened:
        raise _no_answer(talk, timeout_s)


def _check_protocol(talk: Dialogue) -> None:
    spoken = talk.inbox.protocol
    if spoken not in (None, PROTOCOL):
        raise ProtocolMismatch(
            f"the board speaks protocol {spoken}, this program protocol {PROTOCOL}; flash the "
            f"firmware that belongs to it: {FLASH.format(port=talk.link.name)}"
        )


def _no_answer(talk: Dialogue, timeout_s: float) -> NoAnswer:
    flash = FLASH.format(port=talk.link.name)
    foreign = talk.inbox.foreign
    if talk.inbox.heard:
        what = "lines came, but no greeting for ours: another program may write to it too"
    elif foreign:
        what = (
            f"what came is not of this firmware at {BAUD} baud, such as {foreign[:40]!r}; if this "
            f"is the robot, check cable and ground, then flash it: {flash}"
        )
    else:
        what = f"nothing came; is this the robot's port, and is it flashed? {flash}"
    return NoAnswer(f"no greeting from {talk.link.name} within {timeout_s:g} s: {what}")
