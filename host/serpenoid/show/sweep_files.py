"""A sweep as npz, CSV or plain lists; every name carries its unit."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.files import whole_file, write_csv
from ..periodic.sweep import Sweep

AXES = ("alpha_rad", "beta_rad", "omega_rad_s")


def _arrays(grid_states: Sweep) -> dict[str, NDArray[Any]]:
    arrays = {field.name: getattr(grid_states, field.name) for field in fields(grid_states)}
    return {name: values for name, values in arrays.items() if values is not None}


def write_sweep(grid_states: Sweep, path: Path) -> None:
    """Write a sweep of one robot and ground in the format that the suffix names."""
    if path.suffix.lower() == ".npz":
        with whole_file(path) as part, part.open("wb") as file:  # NumPy renames an .NPZ
            np.savez_compressed(file, allow_pickle=False, **_arrays(grid_states))
    else:
        arrays = _arrays(grid_states)  # one gait a row, numbers by their shortest exact digits
        grid = np.meshgrid(*(arrays.pop(axis) for axis in AXES), indexing="ij")
        values = [v.astype(int) if v.dtype == bool else v for v in arrays.values()]
        cells = [column.flat for column in (*grid, *values)]  # lists take four times as much
        write_csv(path, [*AXES, *arrays], zip(*cells, strict=True))


def _plain(values: NDArray[Any]) -> list[Any]:
    """Return nested lists with everything that is not finite as None."""
    if values.dtype != bool and not np.isfinite(values).all():
        finite = np.isfinite(values)
        values = values.astype(object)
        values[~finite] = None
    plain: list[Any] = values.tolist()
    return plain


def sweep_values(grid_states: Sweep) -> dict[str, Any]:
    """Return a sweep as plain lists, indexed [alpha, beta, omega]; angles in degrees, too."""
    return {
        "alpha_deg": np.degrees(grid_states.alpha_rad).round(10).tolist(),
        "beta_deg": np.degrees(grid_states.beta_rad).round(10).tolist(),
    } | {name: _plain(values) for name, values in _arrays(grid_states).items()}
