"""The command `serpenoid sweep`: every gait of a grid."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from .options import AS_JSON, TypedCommand, make_robot, robot_options, show_json
from .paths import OutFile

SUFFIXES = (".csv", ".npz", ".json")


def _span(text: str, name: str) -> list[float]:
    """Read FIRST:LAST:STEP, or one number."""
    try:
        numbers = [float(part) for part in text.split(":")]
        if not all(math.isfinite(v) for v in numbers) or len(numbers) not in (1, 3):
            raise ValueError
        if len(numbers) == 1:
            return numbers
        first, last, step = numbers
        if not (step > 0 and last >= first and (last - first) / step < 1e5):
            raise ValueError
    except ValueError:
        raise click.BadParameter(f"{text!r} is not FIRST:LAST:STEP", param_hint=name) from None
    return [first + i * step for i in range(int((last - first) / step + 1 + 1e-9))]


@click.command(cls=TypedCommand)
@robot_options
@click.option("--alpha-deg", default="5:75:5", show_default=True, help="FIRST:LAST:STEP.")
@click.option("--beta-deg", default="20:90:5", show_default=True, help="FIRST:LAST:STEP.")
@click.option("--omega-rad-s", default="1:20:1", show_default=True, help="FIRST:LAST:STEP.")
@click.option("--rtol", type=float, default=1e-6, show_default=True, help="Relative accuracy.")
@click.option("--threads", type=int, help="Threads to solve in; one a processor unless given.")
@click.option("--out", type=OutFile(*SUFFIXES), help="CSV, npz or JSON file to write.")
@AS_JSON
def sweep(
    as_json: bool,
    out: Path | None,
    alpha_deg: str,
    beta_deg: str,
    omega_rad_s: str,
    rtol: float,
    threads: int | None,
    **given: Any,
) -> None:
    """Solve every gait of a grid (the paper's 4500 unless told), into a file or as JSON."""
    from ..periodic.sweep import sweep as run_sweep
    from ..show import report
    from ..show.sweep_files import sweep_values, write_sweep

    if out is None and not as_json:
        raise click.UsageError("give --out FILE.csv, or --json for an answer on the screen")
    robot, ground = make_robot(given)
    alpha, beta = _span(alpha_deg, "--alpha-deg"), _span(beta_deg, "--beta-deg")
    omega = _span(omega_rad_s, "--omega-rad-s")
    count = len(alpha) * len(beta) * len(omega)
    with report.progress(count, "gaits") as advance:
        found = run_sweep(
            robot, ground, alpha_rad=[math.radians(a) for a in alpha],
            beta_rad=[math.radians(b) for b in beta], omega_rad_s=omega, rtol=rtol,
            threads=threads, progress=advance,
        )  # fmt: skip
    if out is not None:
        write_sweep(found, out)
        missed = int((~found.converged).sum())
        report.notices.print(f"wrote {count} gaits to {out}; {missed} did not converge")
    if as_json:
        show_json(sweep_values(found))
