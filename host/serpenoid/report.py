"""What the command line prints and writes: tables, summaries, CSV files, progress."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

if TYPE_CHECKING:
    from .friction_result import FrictionFit
    from .simulation import Run
    from .steady import Steady, Sweep

console = Console(width=100) if not Console().is_terminal else Console()
notices = Console(stderr=True, soft_wrap=True, highlight=False)  # what is no answer


@contextmanager
def progress(total: int, what: str) -> Iterator[Callable[[int], None]]:
    """Show a bar on standard error; gives a function that takes the number just done."""
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done: bar.advance(task, done)


@contextmanager
def busy(what: str) -> Iterator[None]:
    """Show on standard error, where that is a terminal, that work of unknown length goes on."""
    with Console(stderr=True).status(what):
        yield


def table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """Print a table; the first column is text, the others numbers."""
    made = Table(title=title, title_justify="left", title_style="bold", header_style="")
    for i, column in enumerate(columns):
        made.add_column(column, justify="left" if i == 0 else "right")
    for row in rows:
        made.add_row(*row)
    console.print(made)


def steady(s: Steady) -> None:
    """Print a periodic state."""
    gait = s.gait
    rows = [
        ["speed", f"{s.speed_m_s:.6g} m/s"],
        ["net power", f"{s.power_w:.6g} W"],
        ["power, each joint's absolute value", f"{s.abs_power_w:.6g} W"],
        ["power, no regeneration", f"{s.positive_power_w:.6g} W"],
        ["turn per cycle", f"{math.degrees(s.turn_rad_per_cycle):.4g} deg"],
        ["settling time (to 1/e)", f"{s.settling_time_s:.3g} s"],
        ["error of the speed, estimated", f"{s.error_estimate:.1g} relative"],
    ]
    title = (
        f"alpha {math.degrees(gait.alpha_rad):.4g} deg, "
        f"beta {math.degrees(gait.beta_rad):.4g} deg, omega {gait.omega_rad_s:.5g} rad/s"
    )
    table(title, ["periodic state, exact model", "value"], rows)


def fit(found: FrictionFit) -> None:
    """Print fitted friction with its intervals."""
    rows = [
        [r.name, r.unit, f"{r.value:.4g}", f"{r.sigma:.2g}", f"{r.low:.3g} to {r.high:.3g}"]
        for r in found.rows()
    ]
    columns = ["whole snake", "unit", "value", "sigma", "95 % interval"]
    table(f"friction, {found.method} fit", columns, rows)
    p_value = found.p_value
    chance = "" if p_value is None else f" (p = {p_value:.2g})"
    console.print(f"chi2 = {found.chi2:.3g} for {found.dof} degrees of freedom{chance}")
    for note in found.notes:
        console.print(f"note: {note}", highlight=False)


def run_summary(run: Run) -> dict[str, Any]:
    """Return what a run in time came to."""
    t, x, y = run.t_s, run.x_m.mean(axis=1), run.y_m.mean(axis=1)
    scene = run.scene
    period = scene.gait.period_s
    whole = t[-1] >= period
    dx, dy = (v[-1] - np.interp(t[-1] - period, t, v) for v in (x, y))
    return {
        "formulation": scene.formulation,
        "method": scene.method,
        "dt_s": scene.dt_s,
        "duration_s": float(run.t_s[-1]),
        "displacement_m": float(np.hypot(x[-1] - x[0], y[-1] - y[0])),
        "speed_over_last_period_m_s": float(np.hypot(dx, dy) / period) if whole else None,
        "end": {
            "x_m": run.x_m[-1].tolist(),
            "y_m": run.y_m[-1].tolist(),
            "theta_rad": run.theta_rad[-1].tolist(),
        },
    }


def springs_error(soft: dict[str, Any], exact: dict[str, Any]) -> dict[str, Any]:
    """Return what the implicit model's springs change, against the exact model's same run."""
    name = "speed_over_last_period_m_s"
    if exact[name] is None:
        return {f"exact_model_{name}": None, "springs_error": None}
    error = soft[name] / exact[name] - 1 if exact[name] > 0 else math.inf
    return {f"exact_model_{name}": exact[name], "springs_error": error}


def run(found: Run, summary: dict[str, Any]) -> None:
    """Print what a run in time came to."""
    speed = summary["speed_over_last_period_m_s"]
    rows = [
        ["displacement of the centre of mass", f"{summary['displacement_m']:.6g} m"],
        ["speed over the last period",
         "the run is shorter than a period" if speed is None else f"{speed:.6g} m/s"],
    ]  # fmt: skip
    scene = found.scene
    title = f"{scene.formulation} model, {scene.method}, {scene.dt_s:g} s, {found.t_s[-1]:g} s long"
    table(title, ["run", "value"], rows)
    if summary.get("springs_error") is not None:
        console.print(
            f"The exact model gives {summary['exact_model_speed_over_last_period_m_s']:.6g} m/s: "
            f"the joints' springs (k = {scene.joint_stiffness_n_m:g} N/m) change the speed by "
            f"{100 * summary['springs_error']:+.2g} %. Stiffer ones change it less, as 1/k.",
            highlight=False,
        )


def write_run(found: Run, path: Path) -> None:
    """Write a run as CSV: time, then x, y, theta of every link."""
    links = range(1, found.x_m.shape[1] + 1)
    header = ["t_s", *(f"{name}{i}_{unit}" for i in links
                       for name, unit in (("x", "m"), ("y", "m"), ("theta", "rad")))]  # fmt: skip
    columns = np.stack([found.x_m, found.y_m, found.theta_rad], axis=2)
    rows = np.column_stack([found.t_s, columns.reshape(found.t_s.size, -1)])
    _write_csv(path, header, rows.tolist())
    notices.print(f"wrote {path}")


def write_sweep(found: Sweep, path: Path) -> None:
    """Write a sweep as CSV, one gait a row."""
    header = ["alpha_rad", "beta_rad", "omega_rad_s", "speed_m_s", "power_w", "abs_power_w",
              "positive_power_w", "converged"]  # fmt: skip
    rows = [
        [found.alpha_rad[i], found.beta_rad[j], found.omega_rad_s[k], found.speed_m_s[i, j, k],
         found.power_w[i, j, k], found.abs_power_w[i, j, k], found.positive_power_w[i, j, k],
         int(found.converged[i, j, k])]
        for i, j, k in np.ndindex(found.speed_m_s.shape)
    ]  # fmt: skip
    _write_csv(path, header, rows)
    missed = int((~found.converged).sum())
    notices.print(f"wrote {len(rows)} gaits to {path}; {missed} did not converge")


def sweep_values(found: Sweep) -> dict[str, Any]:
    """Return a sweep as plain lists, indexed [alpha, beta, omega], angles in degrees."""
    names = ("omega_rad_s", "speed_m_s", "power_w", "abs_power_w", "positive_power_w", "converged")
    return {
        "alpha_deg": np.degrees(found.alpha_rad).tolist(),
        "beta_deg": np.degrees(found.beta_rad).tolist(),
    } | {name: getattr(found, name).tolist() for name in names}


def _write_csv(path: Path, header: list[str], rows: list[list[Any]]) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)
