"""What a board tells about itself: its data lines as values, in the units of PROTOCOL.md."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from ..._core import firmware
from ...base.errors import DamagedLine
from .encoding import count_in, number_in
from .protocol import Data


@dataclass(frozen=True)
class Status:
    """The board's state and counters since its start; they stay at 65535.

    Counts of lines to the board: good; damaged: refused, as they came damaged or out of order;
    lost: missing between the numbers of those that came. dropped: lines from the board that its
    output had no room for. rxfull: bytes lost as its receive buffer was full. overruns: frames
    missed; clipped: frames in which a joint was held back; late_us, longest_pass_us: the latest
    frame and the longest pass of its loop; stack_bytes: RAM never touched.
    """

    state: str
    moving: bool
    boot: int
    frame: int
    good: int
    damaged: int
    lost: int
    dropped: int
    rxfull: int
    overruns: int
    clipped: int
    late_us: int
    longest_pass_us: int
    stack_bytes: int


@dataclass(frozen=True)
class Trim:
    """One servo: joint 1 is at the tail; pulse = centre + direction * scale * angle."""

    joint: int
    centre_us: float
    scale_us_rad: float
    direction: float
    low_deg: float
    high_deg: float


@contextmanager
def damage_named(what: str) -> Iterator[None]:
    """Raise DamagedLine for what a broken line lacks."""
    try:
        yield
    except (KeyError, IndexError, ValueError) as error:
        raise DamagedLine(f"{what} lacks {error}; ask again") from None


def status_of(data: list[Data]) -> Status:
    """Return the status in the three lines that answer `status`; raise DamagedLine."""
    with damage_named("the board's status"):
        values = _values(" ".join(line.text for line in data))
        counts = Status.__dataclass_fields__.keys() - {"state", "moving", "stack_bytes"}
        return Status(
            state=values["state"],
            moving=values["moving"] == "1",
            stack_bytes=count_in("stack", values["stack"]),
            **{name: count_in(name, values[name]) for name in counts},
        )


def settings_of(data: list[Data]) -> dict[str, float]:
    """Return name -> value from the lines that answer `set`; raise DamagedLine."""
    with damage_named("a setting of the board"):
        texts = {line.text.split()[0]: _values(line.text)["value"] for line in data}
        values = {name: number_in(name, text) for name, text in texts.items()}
        return {name: values[name] for name in firmware.SETTINGS} | values


def trims_of(data: list[Data], joints: int) -> tuple[Trim, ...]:
    """Return all servos from the lines that answer `trim`; raise DamagedLine."""
    with damage_named("a trim of the board"):
        trims = [_trim(d.text) for d in data]
    if [t.joint for t in trims] != list(range(1, joints + 1)):
        raise DamagedLine(f"the board listed the trims of joints {[t.joint for t in trims]}")
    return tuple(trims)


def _trim(text: str) -> Trim:
    values = _values(text)
    joint = count_in("joint", text.split(maxsplit=1)[0].removeprefix("#"), 1, 99)
    names = ("centre", "scale", "dir", "low", "high")
    return Trim(joint, *(number_in(name, values[name]) for name in names))


def _values(text: str) -> dict[str, str]:
    return dict(word.split("=", 1) for word in text.split() if "=" in word)
