"""What the command line prints of a simulated run: summary and table."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..simulation.run import ENERGY_COLUMNS, Run
from ..simulation.scene_file import scene_values
from .report import show, warn


def run_summary(run: Run, errors: bool = True) -> dict[str, Any]:
    """Return a run's results for JSON; errors: whether to estimate its errors by further runs."""
    scene = run.scene
    speed = run.last_speed_m_s
    state = "x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s"
    joint_loads = "joint_force_x_n", "joint_force_y_n", "joint_torque_nm"
    summary = {
        "formulation": scene.formulation,
        "method": scene.method,
        "dt_s": scene.dt_s,
        "duration_s": float(run.t_s[-1]),
        "steps": run.steps,
        "local_error": run.local_error if scene.adaptive else None,
        "displacement_m": run.travel_m,
        "speed_over_last_period_m_s": None if np.isnan(speed) else speed,
        "end": {name: getattr(run, name)[-1].tolist() for name in state},
        "scene": scene_values(scene),
    }
    summary["picked"] = run.picked or None
    summary["error_estimate"] = run.error_estimate.to_dict() if errors else None
    summary["warnings"] = list(run.warnings) if errors else []
    summary |= {
        f"largest_{name}": np.abs(getattr(run, name)).max(axis=0).tolist()
        for name in (*joint_loads, "friction_x_n", "friction_y_n")
        if getattr(run, name).size
    }
    if run.energy_j.size:
        summary["energy_at_end"] = dict(zip(ENERGY_COLUMNS, run.energy_j[-1].tolist(), strict=True))
    return summary


def show_run(run: Run, summary: dict[str, Any], verbose: bool) -> None:
    """Print the warnings of a summary, then the run's results, with its errors if estimated."""
    for warning in summary["warnings"]:
        warn(warning)
    errors = [] if summary["error_estimate"] is None else [run.error_estimate]
    show(run, *errors, verbose=verbose)
