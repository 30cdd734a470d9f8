"""What a person sees while a robot is driven: a live table, or plain lines where there is none."""

from __future__ import annotations

import errno
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Group
from rich.live import Live
from rich.table import Table

from ..base.rows import table
from ..robot.tools.driven_run import DrivenRun, Summary
from ..robot.wire.protocol import Telemetry
from .screen import screen

View = Callable[[DrivenRun], None]


@contextmanager
def view(band: Any = None) -> Iterator[View]:
    """Give a function that shows the state of a run; call it after every frame.

    band: the speed that is predicted for the gait, to stand beside.
    """
    console = screen()
    if not console.is_terminal:
        yield _thinned(50, lambda run, frame: print(line(run, frame), flush=True))
        return
    with Live(console=console, auto_refresh=False) as live:

        def show(run: DrivenRun, frame: Telemetry) -> None:
            if not console.is_terminal:  # rich would go on without a word
                raise OSError(errno.EIO, "the terminal was closed")
            live.update(tables(run, frame, band), refresh=True)

        yield _thinned(5, show)


def _thinned(frames: int, show: Callable[[DrivenRun, Telemetry], None]) -> View:
    """Return what shows a run and its latest frame, of so many one, and none that is outdated.

    So a slow terminal shows fewer of them, and what it shows is true.
    """
    shown = 0

    def watch(run: DrivenRun) -> None:
        nonlocal shown
        if run.last is not None and run.last is run.robot.latest and run.frames > shown:
            shown = run.frames + frames - 1
            show(run, run.last)

    return watch


def line(run: DrivenRun, frame: Telemetry) -> str:
    """Return the run's state as one line of text."""
    losses = run.robot.losses
    angles = " ".join(f"{math.degrees(a):7.2f}" for a in frame.setpoint_rad)
    return (
        f"{run.elapsed_s:7.1f} s  {frame.state:6}  {angles} deg  late {frame.late_us} us  "
        f"missed {losses.missed_frames}  damaged {losses.damaged_lines}  "
        f"clipped {run.clipped_frames}"
    )


def tables(run: DrivenRun, frame: Telemetry, band: Any) -> Group:
    """Return the run's state as tables: distance, joints, then timing and losses."""
    joints = zip(frame.setpoint_rad, frame.pulse_us, strict=True)
    cells = [[str(j), f"{math.degrees(a):.2f}", str(us)] for j, (a, us) in enumerate(joints, 1)]
    return Group(
        _facts(run.summary(), band),
        table(
            f"{frame.state}, {run.elapsed_s:.1f} s", ["joint", "setpoint, deg", "pulse, us"], cells
        ),
        "Ctrl-C stops the robot",
    )


def show_summary(summary: Summary, band: Any = None) -> None:
    """Print what a run came to, and the speed that was predicted for it."""
    screen().print(_facts(summary, band))
    if summary.recording:
        screen().print(f"see how it moved: serpenoid view {summary.recording}")


def _facts(summary: Summary | None, band: Any) -> Table | str:
    """Return a table of what a run came to until now, with the speed and distance to expect."""
    if summary is None:
        return ""
    s, rows = summary, list[tuple[str, str]]()
    if band is not None:
        distances_m = [
            getattr(band, name, math.nan) * s.duration_s
            for name in ("speed_m_s", "low_m_s", "high_m_s")
        ]
        words = "{:.2f} m ({:.2f} to {:.2f})".format(*distances_m).replace(" (nan to nan)", "")
        rows = [("predicted speed", band.in_words()), ("predicted distance", words)]
    hertz = f"{s.frequency_hz:.5f} ± {s.frequency_sd_hz:.5f} Hz" if s.frequency_hz else "unknown"
    rows += [
        ("board", f"{s.board}, firmware {s.firmware}"),
        ("driven", f"{s.duration_s:.2f} s"),
        ("frames", f"{s.frames}, missed {s.missed_frames}, unread {s.unread_frames}"),
        ("damaged lines", f"{s.damaged_lines}, commands sent again {s.resent_commands}"),
        ("latest frame", f"{s.latest_us} us"),
        ("clipped frames", str(s.clipped_frames)),
        ("board's clock", f"{s.drift_ppm:+.0f} ± {s.drift_sd_ppm:.0f} ppm"),
        ("true gait frequency", hertz),
        ("recording", s.recording or "none (--record FILE)"),
    ]
    return table("", ["", ""], rows, 2)
