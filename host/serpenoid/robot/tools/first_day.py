"""Collect what a board and its host can tell of themselves, as facts for a first day's report."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict
from itertools import islice

from ...model.errors import CommandRefused, RobotError
from ...model.gait import Gait
from ..robot import RobotBoard
from ..wire.protocol import Telemetry
from .trimming import UNATTENDED_S, straighten

FRAMES = 10_000
FRAME_PATIENCE_S = 400.0
QUESTIONS = 200
SLOW = Gait(math.radians(10), math.radians(60), 2.0)
SLOW_S = 10.0
RELEASED = {
    0.0: "nobody has tried whether these servos go limp when pulses end",
    1.0: "these servos go limp when pulses end",
    2.0: "these servos hold when pulses end: only the switch stops them",
}
FREE = "Has the robot free space all around, and is the switch within reach of your hand?"
TURNS = (
    "No pulses come now. Take one servo with its horn on that is linked to no other. Can you turn "
    "its horn by hand?"
)

Ask = Callable[[str], bool]


def measure(port: str | None, ask: Ask | None) -> dict[str, object]:
    """Return the facts by name; what a failure leaves is kept beside it, under `failure`.

    ask: puts a question to the person at the robot, who answers yes or no; None moves nothing.
    """
    facts: dict[str, object] = {}
    try:
        with RobotBoard(port, unattended_s=UNATTENDED_S) as robot:
            facts["greeting"] = asdict(robot.hello)
            facts["settings"], facts["trims"] = robot.settings(), [*map(asdict, robot.trims())]
            with suppress(CommandRefused):  # frames too short for a line in each
                robot.set("every", 1)
            facts["round_trip_ms"] = _round_trip(robot)
            facts["frames"] = _frames(islice(robot.frames(FRAME_PATIENCE_S), FRAMES))
            if ask is None:
                facts["left_out"] = "limp test and slow gait: give --move, with the robot free"
            elif ask(FREE):
                facts["released"] = limp_test(robot, ask)
                facts["slow_gait"] = _slow_gait(robot)
            else:
                facts["left_out"] = "limp test and slow gait: the space was not free"
            facts |= {"status": asdict(robot.status()), "losses": asdict(robot.losses)}
            facts["clock"] = asdict(robot.clock)
    except RobotError as error:
        facts["failure"] = f"{type(error).__name__}: {error}"
    return facts


def limp_test(robot: RobotBoard, ask: Ask) -> str:
    """Ask whether a servo turns by hand without pulses, and keep the answer on the board."""
    straighten(robot)
    robot.idle()
    released = 1.0 if ask(TURNS) else 2.0
    robot.set("released", released)
    robot.save()
    return RELEASED[released]


def _round_trip(robot: RobotBoard) -> dict[str, float]:
    times_ms = []
    for _ in range(QUESTIONS):
        begun_s = time.perf_counter()
        robot.command("ping")
        times_ms.append(1e3 * (time.perf_counter() - begun_s))
    return _spread(times_ms)


def _frames(coming: Iterable[Telemetry]) -> dict[str, object]:
    """Return how late frames were, how long they took, in us, and how many joints were clipped."""
    frames = list(coming)
    return {
        "count": len(frames),
        "late_us": _spread([frame.late_us for frame in frames]),
        "exec_us": _spread([frame.exec_us for frame in frames]),
        "clipped": sum(frame.clipped > 0 for frame in frames),
    }


def _slow_gait(robot: RobotBoard) -> dict[str, object]:
    robot.gait(SLOW)
    frames = _frames(robot.frames(SLOW_S))
    begun_s = time.perf_counter()
    robot.stop()
    stop_ms = 1e3 * (time.perf_counter() - begun_s)
    robot.idle()
    return {**frames, "stop_ms": stop_ms}


def _spread(values: Sequence[float]) -> dict[str, float]:
    ordered = sorted(values)
    places = {"median": 0.5, "p99": 0.99, "worst": 1.0}
    return {name: ordered[round(at * (len(ordered) - 1))] for name, at in places.items() if values}
