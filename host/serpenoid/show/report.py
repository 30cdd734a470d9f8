"""What the command line prints and writes: tables, summaries, CSV files, progress."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    TextColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from .screen import screen

if TYPE_CHECKING:
    from ..calibration.friction_result import FrictionFit
    from ..model.drives import Servo, ServoKind
    from ..model.gait import Gait
    from ..periodic.servo_steady import ServoSteady
    from ..periodic.steady import Steady
    from ..simulation.steady_springs import SteadySprings

console = screen(width=100) if not screen().is_terminal else screen()
notices = screen(stderr=True, soft_wrap=True, highlight=False)  # what is no answer


def _bar(columns: tuple[ProgressColumn, ...]) -> Progress:
    """Return a bar on standard error that leaves no trace, and none at all off a terminal."""
    errors = screen(stderr=True)
    return Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal)


@contextmanager
def simulated_time(duration_s: float, what: str) -> Iterator[Callable[[float], None]]:
    """Show how far a run is; gives a function that takes the simulated time."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.4g} of {task.total:g} s"),
        TimeRemainingColumn(),
    )
    with _bar(columns) as bar:
        task = bar.add_task(what, total=duration_s)
        yield lambda t_s: bar.update(task, completed=t_s)


@contextmanager
def busy(what: str) -> Iterator[None]:
    """Show on standard error, where that is a terminal, that work of unknown length goes on."""
    with screen(stderr=True).status(what):
        yield


def wrote(*paths: Path) -> None:
    """Say on standard error which files were written."""
    notices.print("wrote " + " and ".join(map(str, paths)))


def table(title: str, columns: list[str], rows: list[list[str]], text_columns: int = 1) -> None:
    """Print a table; the first columns are text, the others numbers. Nothing is cut off."""
    made = Table(title=title, title_justify="left", title_style="bold", header_style="")
    for i, column in enumerate(columns):
        made.add_column(column, justify="left" if i < text_columns else "right", overflow="fold")
    for row in rows:
        made.add_row(*row)
    console.print(made)


def gait_words(gait: Gait) -> str:
    """Return a gait as it is typed."""
    angles = {"alpha": gait.alpha_rad, "beta": gait.beta_rad, "offset": gait.offset_rad}
    if not gait.offset_rad:
        del angles["offset"]
    words = [f"{name} {math.degrees(angle):.5g} deg" for name, angle in angles.items()]
    return ", ".join([*words, f"omega {gait.omega_rad_s:.5g} rad/s"])


def _settling(s: Steady) -> str:
    if s.settling_error >= 1 and s.settling_time_s < 0.1 * s.gait.period_s:
        return "under a cycle"  # wheels that stick forget all at once
    return f"{s.settling_time_s:.3g} s"


def steady(s: Steady) -> None:
    """Print a periodic state."""
    rows = [
        ["speed", f"{s.speed_m_s:.6g} m/s"],
        ["net power", f"{s.power_w:.6g} W"],
        ["power, each joint's absolute value", f"{s.abs_power_w:.6g} W"],
        ["power, no regeneration", f"{s.positive_power_w:.6g} W"],
        ["turn per cycle", f"{math.degrees(s.turn_rad_per_cycle):.4g} deg"],
        ["radius of the path", f"{s.radius_m:.4g} m" if s.radius_m < math.inf else "straight"],
        ["settling time (to 1/e), near this state", _settling(s)],
        ["error of the speed, estimated", f"{s.error_estimate:.1g} relative"],
    ]
    table(gait_words(s.gait), ["periodic state, exact model", "value"], rows)


def answer(text: str) -> None:
    """Print what a builder asks, before all tables."""
    console.print(text, highlight=False)


def speed_words(ideal: Steady, s: ServoSteady | None) -> str:
    """Return what a builder may expect: a speed with its band, or that servos cannot run it."""
    if s is None:
        return f"About {ideal.speed_m_s:#.2g} m/s with ideal joints; servos may be slower."
    if not s.moves:
        return (
            f"Typical {s.name} servos cannot move this robot: its joints reach "
            f"{s.amplitude_ratio:.0%} of the gait's amplitude. So it has no band."
        )
    if not s.follows:
        return (
            f"Most {s.name} servos cannot run this gait: it asks {s.asked_rad_s:.2g} rad/s of "
            f"their {s.free_rad_s:.2g}; they manage {s.managed_hz:.2g} Hz. So it has no band."
        )
    band = f"{s.low_m_s:#.2g} to {s.high_m_s:#.2g}"
    return (
        f"About {s.speed_m_s:#.2g} m/s with typical servos ({band}); ideal joints "
        f"{s.ideal.speed_m_s:#.2g}."
    )


def _kind_rows(servo: Servo | ServoKind) -> list[list[str]]:
    """Return where a kind of servo comes from, and at which voltage."""
    from ..model.drives import ServoKind

    if not isinstance(servo, ServoKind):
        return []
    spread = math.exp(math.sqrt(3) * servo.sigma.get("supply_v", 0.0))
    low, high = servo.servo.supply_v / spread, servo.servo.supply_v * spread
    volts = f"{low:.3g} to {high:.3g} V: not measured" if spread > 1 else f"{low:.3g} V"
    return [["source", servo.source], ["voltage at the plug", volts if low else "not stated"]]


def with_servo(s: ServoSteady) -> None:
    """Print the speed with servos beside that of ideal joints."""
    band = f"{s.low_m_s:#.2g} to {s.high_m_s:#.2g} m/s" if s.follows else "none"
    rows = [
        *_kind_rows(s.servo),
        ["speed, ideal joints", f"{s.ideal.speed_m_s:.4g} m/s"],
        ["speed, typical servo", f"{s.speed_m_s:.4g} m/s"],
        ["speed, 95 % of such servos", band],
        [
            "joints: amplitude reached, lag",
            f"{s.amplitude_ratio:.0%}, {math.degrees(s.lag_rad):.0f} deg",
        ],
        ["joints: rate beside the sine, rms", f"{s.ripple_rad_s:.2g} rad/s"],
        ["joints: fastest rate asked", f"{s.asked_over_free_speed:.0%} of the free speed"],
        ["such servos that are slower", f"{s.slower_servos:.0%}"],
        ["error of the speed, estimated", f"{s.error_estimate:.1g} relative"],
    ]
    table(f"servos: {s.name}", ["with servos on the board's frames", "value"], rows)


def steady_springs(s: SteadySprings, gait: Gait) -> None:
    """Print a periodic state of the implicit model, and what its springs change."""
    answer(f"About {s.speed_m_s:#.2g} m/s with the implicit model's springs for joints.")
    rows = [
        ["speed", f"{s.speed_m_s:.6g} m/s"],
        ["net power", f"{s.power_w:.6g} W"],
        ["power, each joint's absolute value", f"{s.abs_power_w:.6g} W"],
        ["power, no regeneration", f"{s.positive_power_w:.6g} W"],
        ["error of the speed by time steps and settling", f"{s.error_estimate:.1g} relative"],
        ["error of the speed by the springs", f"{100 * s.modelling_error:+.3g} %"],
    ]
    table(
        f"{gait_words(gait)}; after {s.cycles} cycles",
        ["periodic state, implicit model", "value"],
        rows,
    )


def fit(found: FrictionFit) -> None:
    """Print fitted friction with its intervals, of the whole snake and of one link."""
    links, whole = found.robot.links, found.whole_snake
    answer(
        f"Along, the snake resists with {whole['ft0']:.2g} N and {whole['ct']:.2g} N s/m; across, "
        f"with {whole['fn0']:.2g} N and {whole['cn']:.2g} N s/m."
    )
    rows = [
        [r.name, r.unit, f"{r.value:.4g}", f"{r.sigma:.2g}", r.interval, f"{r.value / links:.4g}"]
        for r in found.rows()
    ]
    columns = ["whole snake", "unit", "value", "sigma", "95 % interval", f"per link (of {links})"]
    table(f"friction, {found.method} fit", columns, rows)
    console.print(found.chi2_in_words)
    for note in found.notes:
        console.print(f"note: {note}", highlight=False)


def influence(found: FrictionFit) -> None:
    """Print what every reading does: how the parameters would move without it."""
    rows = [
        [str(i.reading), f"{i.studentised:+.1f}", f"{i.leverage:.2f}", f"{i.chi2_without:.1f}"]
        + [f"{shift:+.2f}" for shift in i.shift]
        for i in found.influence
    ]
    columns = ["reading", "off by", "leverage", "chi2 without", "ct", "cn", "ft0", "fn0"]
    table("without each reading, parameters would move by (in their sigmas)", columns, rows)
