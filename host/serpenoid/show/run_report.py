"""What the command line says of one run in time: summary, table, CSV file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..simulation.run import ENERGY_COLUMNS
from ..simulation.scene_file import scene_values
from .report import answer, console, notices, table, wrote

if TYPE_CHECKING:
    from ..simulation.error import RunError
    from ..simulation.run import Run

STATE = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s")
FORCES = ("joint_force_x_n", "joint_force_y_n", "joint_torque_nm", "friction_x_n", "friction_y_n")


def run_summary(run: Run, errors: bool = True) -> dict[str, Any]:
    """Return what a run came to; errors=False leaves out what costs more runs."""
    scene = run.scene
    mean_speed = [] if _too_rare(run) else run.mean_speed_m_s(scene.gait.period_s)
    summary = {
        "formulation": scene.formulation,
        "method": scene.method,
        "dt_s": scene.dt_s,
        "duration_s": float(run.t_s[-1]),
        "steps": run.steps,
        "local_error": run.local_error if scene.adaptive else None,
        "displacement_m": run.travel_m,
        "speed_over_last_period_m_s": float(mean_speed[-1]) if len(mean_speed) else None,
        "end": {name: getattr(run, name)[-1].tolist() for name in STATE},
        "scene": scene_values(scene),
    }
    summary["picked"] = run.picked or None
    summary["error_estimate"] = run.error_estimate.to_dict() if errors else None
    summary["warnings"] = list(run.warnings) if errors else []
    return summary | _recorded(run)


def _too_rare(run: Run) -> bool:
    """Tell whether the last period's start is between recorded times that say nothing of it."""
    period, t = run.scene.gait.period_s, run.t_s
    near = np.abs(t - (t[-1] - period)).min()
    return bool(t.size > 1 and near > 1e-6 * period and np.diff(t).max() > period / 8)


def _recorded(run: Run) -> dict[str, Any]:
    """Return the extremes of forces and torques, and the ledger at the end, where recorded."""
    found: dict[str, Any] = {
        f"largest_{name}": np.abs(getattr(run, name)).max(axis=0).tolist()
        for name in FORCES
        if getattr(run, name).size
    }
    if run.energy_j.size:
        found["energy_at_end"] = dict(zip(ENERGY_COLUMNS, run.energy_j[-1].tolist(), strict=True))
    return found


def _error_rows(error: RunError) -> list[list[str]]:
    parts = {"integration": error.integration, "modelling (springs)": error.modelling}
    return [
        [
            f"error by {name}",
            f"{part.position_m:.2g} m, {part.angle_rad:.2g} rad, "
            f"mean speed {_share(part.mean_speed)}",
        ]
        for name, part in parts.items()
        if part is not None
    ]


def _share(relative: float) -> str:
    if math.isinf(relative):
        return "of what should rest"
    return "of nothing: at rest" if math.isnan(relative) else f"{relative:+.2g}"


def _why_no_speed(run: Run) -> str:
    if run.t_s[-1] < run.scene.gait.period_s:
        return "the run is shorter than a period"
    return "recorded too rarely: take a smaller --record-every"


def show_run(run: Run, summary: dict[str, Any]) -> None:
    """Print what a run in time came to."""
    scene, speed = run.scene, summary["speed_over_last_period_m_s"]
    pace = "" if speed is None else f", at {speed:#.2g} m/s in the last period"
    answer(f"In {run.t_s[-1]:g} s the robot moves {summary['displacement_m']:#.2g} m{pace}.")
    rows = [
        ["displacement of the centre of mass", f"{summary['displacement_m']:.6g} m"],
        [
            "speed over the last period",
            f"{speed:.6g} m/s" if speed is not None else _why_no_speed(run),
        ],
    ]
    if run.joint_torque_nm.size:
        most = max(summary["largest_joint_torque_nm"])
        rows.append(["largest torque of a joint", f"{most:.4g} N m"])
    rows += [
        [f"{name.removesuffix('_j').replace('_', ' ')} at the end", f"{value:.6g} J"]
        for name, value in summary.get("energy_at_end", {}).items()
    ]
    if summary["error_estimate"] is None:
        rows.append(["error", "not estimated"])
    else:
        rows += _error_rows(run.error_estimate)
    step = f"tolerance {scene.tolerance:g}" if scene.adaptive else f"{scene.dt_s:g} s"
    title = f"{scene.formulation} model, {scene.method}, {step}, {run.t_s[-1]:g} s long"
    table(title, ["run", "value"], rows)
    if run.picked:
        console.print(f"picked {run.picked}", highlight=False)
    for warning in summary["warnings"]:
        notices.print(f"warning: {warning}")


def write_run(run: Run, path: Path) -> None:
    """Write a run as CSV and say so."""
    run.to_csv(path)
    wrote(path)
