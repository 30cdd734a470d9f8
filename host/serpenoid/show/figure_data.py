"""The numbers of a figure as CSV beside it, so that anybody can draw it anew."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..calibration.friction_fit import friction_points, point_errors, voided_points
from ..calibration.friction_result import FrictionFit
from ..calibration.session import Session
from ..model.files import write_csv
from ..prediction.comparison import Comparison

# Of each part of the readings, the parameters of its line.
LINES = {"straight": ("ct", "ft0"), "back": ("ct_back", "ft0_back"), "bent": ("cn", "fn0")}


def beside(path: Path) -> Path:
    """Return the name of the data file beside a picture."""
    return path.with_suffix(".csv")


def write_columns(picture: Path, columns: Mapping[str, Any]) -> None:
    """Write arrays of one size as columns of the file beside a picture."""
    cells = [np.ravel(values).tolist() for values in columns.values()]
    write_csv(beside(picture), list(columns), zip(*cells, strict=True))


def write_parts(
    picture: Path, header: Sequence[str], parts: Iterable[tuple[str, Sequence[np.ndarray]]]
) -> None:
    """Write parts of a picture, each a name and its columns, into the file beside it."""
    rows = [[name, *row] for name, part in parts for row in np.column_stack(part).tolist()]
    write_csv(beside(picture), header, rows)


def by_link(tables: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return a column for each link of tables (T, n): "x{}_m" becomes x1_m, x2_m and so on."""
    return {
        name.format(link): column
        for name, table in tables.items()
        for link, column in enumerate(table.T, 1)
    }


def write_friction(session: Session, fit: FrictionFit, path: Path) -> None:
    """Write what `friction_lines` draws: readings with their sigmas, voided ones, and the lines.

    speed_m_s and force_n are the whole snake's, along the links (straight, back) or across (bent).
    """
    kept, sigmas = friction_points(session, fit), point_errors(session)
    rows: list[list[Any]] = []
    for part, (v, force) in kept.items():
        columns = np.column_stack([v, force, *sigmas[part]])
        rows += [[part, "reading", *row] for row in columns.tolist()]
    for part, points in voided_points(session, fit).items():
        rows += [[part, "voided", *row, "", ""] for row in np.column_stack(points).tolist()]
    for part in LINES:
        if len(kept[part][0]):
            rows += [[part, "line", *row] for row in line(fit, part, kept[part][0]).tolist()]
    header = ["part", "kind", "speed_m_s", "force_n", "sigma_speed_m_s", "sigma_force_n"]
    write_csv(beside(path), header, rows)


def line(fit: FrictionFit, part: str, speeds_m_s: np.ndarray) -> np.ndarray:
    """Return a part's line from rest to beyond the speeds: rows of v, F, 0, sigma of F."""
    order = list(fit.whole_snake)
    picked = [order.index(name) for name in LINES[part]]
    v = np.linspace(0, 1.08 * float(speeds_m_s.max()), 60)
    terms = np.column_stack([v, np.ones_like(v)])
    force = terms @ [fit.parameters[name].value for name in LINES[part]]
    variance = np.sum(terms @ fit.covariance[np.ix_(picked, picked)] * terms, axis=1)
    return np.column_stack([v, force, np.zeros_like(v), np.sqrt(variance)])


def write_comparison(compared: Comparison, path: Path) -> None:
    """Write what `comparison_figure` draws: the curve, and the gaits with what was measured."""
    rows = [
        {"kind": kind} | asdict(point) | {"runs": " ".join(map(str, point.runs))}
        for kind, points in (("curve", compared.curve), ("gait", compared.gaits))
        for point in points
    ]
    write_csv(beside(path), list(rows[0]), [list(row.values()) for row in rows])
