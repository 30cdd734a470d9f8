"""A sweep as a file: npz in SI units, CSV in degrees and hertz; every name carries its unit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..base.files import whole_file, write_csv
from ..periodic.sweep import Sweep


def write_sweep(grid_states: Sweep, path: Path) -> None:
    """Write a sweep of one robot and ground in the format that the suffix names."""
    names = grid_states.__match_args__
    arrays = {k: value for k in names if (value := getattr(grid_states, k)) is not None}
    if path.suffix.lower() == ".npz":
        with whole_file(path) as part, part.open("wb") as file:  # NumPy renames an .NPZ
            np.savez_compressed(file, allow_pickle=False, **arrays)
        return
    axes = {
        "alpha_deg": np.degrees(arrays.pop("alpha_rad")),
        "beta_deg": np.degrees(arrays.pop("beta_rad")),
        "frequency_hz": arrays.pop("omega_rad_s") / math.tau,
    }
    columns = {
        name.replace("turn_rad", "turn_deg"): np.degrees(v) if name.startswith("turn") else v
        for name, v in arrays.items()
    }
    columns["converged"] = columns["converged"].astype(int)
    grid = np.meshgrid(*(values.round(12) for values in axes.values()), indexing="ij")
    header = [*axes, *columns]
    cells = [column.flat for column in (*grid, *columns.values())]  # lists take four times as much
    write_csv(path, header, zip(*cells, strict=True))
