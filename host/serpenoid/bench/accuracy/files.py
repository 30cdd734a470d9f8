"""What the accuracy benchmark writes: rows, ratios at equal error, and the figure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from ...model.files import write_text
from .. import machine
from ..problems import problems
from ..reference import reference
from ..rows import write_rows
from .contenders import absent
from .equal_error import headline
from .figure import accuracy_figure
from .measure import Row


def write_all(rows: Sequence[Row], out: Path) -> None:
    """Write accuracy.csv, .json and .png into a folder, with the machine of the measurement."""
    out.mkdir(parents=True, exist_ok=True)
    here = {"cpu": machine.cpu(), "compiler": machine.compiler()}
    measured = {row.scene for row in rows}
    content = {
        **here,
        "versions": machine.versions(),
        "absent": absent(),
        "references_known_to": {
            p.name: reference(p).known_to for p in problems() if p.name in measured
        },
        "headline": headline(rows),
    }
    write_rows(out / "accuracy.csv", rows, here)
    write_text(out / "accuracy.json", json.dumps(content, indent=1) + "\n")
    accuracy_figure(rows, out / "accuracy.png")
