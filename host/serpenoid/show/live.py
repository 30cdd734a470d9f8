"""What a person sees while a robot is driven: a live table, or plain lines where there is none."""

from __future__ import annotations

import errno
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
    from ..periodic.servo_steady import ServoSteady
    from ..periodic.steady import Steady
    from ..prediction.band import SpeedBand

    Predicted = SpeedBand | ServoSteady | Steady
    from ..robot.wire.protocol import Telemetry

FRAMES_A_TABLE = 5
FRAMES_A_LINE = 50
View = Callable[[DrivenRun], None]


@contextmanager
def view(band: Predicted | None = None) -> Iterator[View]:
    """Give a function that shows the state of a run; call it after every frame.

    band: the speed that is predicted for the gait, to stand beside.
    """
    console = screen()
    if not console.is_terminal:
        yield _thinned(FRAMES_A_LINE, lambda run, frame: print(line(run, frame), flush=True))
        return
    with Live(console=console, auto_refresh=False) as live:

        def show(run: DrivenRun, frame: Telemetry) -> None:
            if not console.is_terminal:  # rich would go on without a word
                raise OSError(errno.EIO, "the terminal was closed")
            live.update(tables(run, frame, band), refresh=True)

        yield _thinned(FRAMES_A_TABLE, show)


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


def tables(run: DrivenRun, frame: Telemetry, band: Predicted | None = None) -> Group:
    """Return the run's state as tables: distance and joints, then timing and losses."""
    losses, drift = run.robot.losses, run.robot.clock
    joints = Table("joint", title=f"{frame.state}, {run.elapsed_s:.1f} s", title_justify="left")
    for name in ("setpoint, deg", "pulse, us"):
        joints.add_column(name, justify="right")
    for j, (angle, pulse) in enumerate(zip(frame.setpoint_rad, frame.pulse_us, strict=True), 1):
        joints.add_row(str(j), f"{math.degrees(angle):.2f}", str(pulse))
    facts = [
        ("phase", f"{math.degrees(frame.phase_rad):.1f} deg"),
        ("frame late", f"{frame.late_us} us, at most {run.latest_us} us"),
        ("frame took", f"{frame.exec_us} us"),
        ("frames", f"{run.frames}, missed {losses.missed_frames}, clipped {run.clipped_frames}"),
        ("damaged lines", str(losses.damaged_lines)),
        ("board's clock", f"{drift.ppm:+.0f} ± {drift.sd_ppm:.0f} ppm"),
        ("true frequency", _frequency(*run.frequency())),
    ]
    expected = [_rows(_expected(band, run.elapsed_s))] if band else []
    return Group(*expected, joints, _rows(facts), "Ctrl-C stops the robot")


def show_summary(summary: Summary, band: Predicted | None = None) -> None:
    """Print what a run came to, and the speed that was predicted for it."""
    rows = [
        ("board", f"{summary.board}, firmware {summary.firmware}"),
        ("driven", f"{summary.duration_s:.2f} s"),
        (
            "frames",
            f"{summary.frames}, missed {summary.missed_frames}, unread {summary.unread_frames}",
        ),
        (
            "damaged lines",
            f"{summary.damaged_lines}, commands sent again {summary.resent_commands}",
        ),
        ("latest frame", f"{summary.latest_us} us"),
        ("clipped frames", str(summary.clipped_frames)),
        ("board's clock", f"{summary.drift_ppm:+.0f} ± {summary.drift_sd_ppm:.0f} ppm"),
        ("true gait frequency", _frequency(summary.frequency_hz, summary.frequency_sd_hz)),
        ("recording", summary.recording or "none (--record FILE)"),
    ]
    screen().print(_rows(_expected(band, summary.duration_s) + rows))
    if summary.recording:
        screen().print(f"see how it moved: serpenoid view {summary.recording}")


def _expected(band: Predicted | None, elapsed_s: float) -> list[tuple[str, str]]:
    """Return the predicted speed, and the distance that it makes until now."""
    if band is None:
        return []
    low_m_s, high_m_s = getattr(band, "low_m_s", math.nan), getattr(band, "high_m_s", math.nan)
    words = f"{band.speed_m_s * elapsed_s:.2f} m"
    if math.isfinite(low_m_s):
        words += f" ({low_m_s * elapsed_s:.2f} to {high_m_s * elapsed_s:.2f})"
    return [("predicted speed", band.in_words()), ("predicted distance", words)]


def _frequency(hz: float | None, sd_hz: float | None) -> str:
    return "unknown" if hz is None else f"{hz:.5f} ± {sd_hz:.5f} Hz"


def _rows(rows: list[tuple[str, str]]) -> Table:
    table = Table(show_header=False)
    table.add_column()
    table.add_column(overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table
