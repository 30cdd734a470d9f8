"""What a person sees while a robot is driven: a live table, or plain lines where there is none."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Group
from rich.live import Live
from rich.table import Table

from ..robot.tools.driven_run import DrivenRun, Summary
from .screen import screen

if TYPE_CHECKING:
    from ..calibration.speed_samples import SpeedBand

FRAMES_A_TABLE = 5
FRAMES_A_LINE = 50
View = Callable[[DrivenRun], None]


@contextmanager
def view(band: SpeedBand | None = None) -> Iterator[View]:
    """Give a function that shows the state of a run; call it after every frame.

    band: the speed that is predicted for the gait, to stand beside.
    """
    console = screen()
    if not console.is_terminal:
        yield _thinned(FRAMES_A_LINE, lambda run: print(line(run), flush=True))
        return
    with Live(console=console, auto_refresh=False) as live:
        yield _thinned(FRAMES_A_TABLE, lambda run: live.update(tables(run, band), refresh=True))


def _thinned(frames: int, show: View) -> View:
    return lambda run: show(run) if run.frames % frames == 1 else None


def line(run: DrivenRun) -> str:
    """Return the run's state as one line of text."""
    frame, losses = run.last, run.robot.losses
    assert frame is not None  # shown after a frame
    angles = " ".join(f"{math.degrees(a):7.2f}" for a in frame.setpoint_rad)
    return (
        f"{run.elapsed_s:7.1f} s  {frame.state:6}  {angles} deg  late {frame.late_us} us  "
        f"missed {losses.missed_frames}  damaged {losses.damaged_lines}  "
        f"clipped {run.clipped_frames}"
    )


def tables(run: DrivenRun, band: SpeedBand | None = None) -> Group:
    """Return the run's state as tables: the joints, then timing and losses."""
    frame = run.last
    assert frame is not None  # shown after a frame
    joints = Table("joint", title=f"{frame.state}, {run.elapsed_s:.1f} s", title_justify="left")
    for name in ("setpoint, deg", "pulse, us"):
        joints.add_column(name, justify="right")
    for j, (angle, pulse) in enumerate(zip(frame.setpoint_rad, frame.pulse_us, strict=True), 1):
        joints.add_row(str(j), f"{math.degrees(angle):.2f}", str(pulse))
    return Group(joints, _rows(_facts(run) + _predicted(band)), "Ctrl-C stops the robot")


def _facts(run: DrivenRun) -> list[tuple[str, str]]:
    frame, losses, drift = run.last, run.robot.losses, run.robot.clock
    assert frame is not None  # shown after a frame
    return [
        ("phase", f"{math.degrees(frame.phase_rad):.1f} deg"),
        ("frame late", f"{frame.late_us} us, at most {run.latest_us} us"),
        ("frame took", f"{frame.exec_us} us"),
        ("frames", f"{run.frames}, missed {losses.missed_frames}, clipped {run.clipped_frames}"),
        ("damaged lines", str(losses.damaged_lines)),
        ("board's clock", f"{drift.ppm:+.0f} ± {drift.sd_ppm:.0f} ppm"),
        ("true frequency", _frequency(*run.frequency())),
    ]


def _predicted(band: SpeedBand | None) -> list[tuple[str, str]]:
    return [] if band is None else [("predicted speed", band.in_words())]


def show_summary(found: Summary, band: SpeedBand | None = None) -> None:
    """Print what a run came to, and the speed that was predicted for it."""
    rows = [
        ("board", f"{found.board}, firmware {found.firmware}"),
        ("driven", f"{found.duration_s:.2f} s"),
        ("frames", f"{found.frames}, missed {found.missed_frames}"),
        ("damaged lines", f"{found.damaged_lines}, commands sent again {found.resent_commands}"),
        ("latest frame", f"{found.latest_us} us"),
        ("clipped frames", str(found.clipped_frames)),
        ("board's clock", f"{found.drift_ppm:+.0f} ± {found.drift_sd_ppm:.0f} ppm"),
        ("true gait frequency", _frequency(found.frequency_hz, found.frequency_sd_hz)),
        ("recording", found.recording or "none (--record FILE)"),
    ]
    screen().print(_rows(rows + _predicted(band)))


def _frequency(hz: float | None, sd_hz: float | None) -> str:
    return "unknown" if hz is None else f"{hz:.5f} ± {sd_hz:.5f} Hz"


def _rows(rows: list[tuple[str, str]]) -> Table:
    table = Table(show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table
