"""The stored figures equal those that the program draws; `make figures` renews them."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest
from docs.documents import ROOT
from matplotlib.image import imread

sys.path.insert(0, str(ROOT / "docs"))
import figures
import film_pictures
from serpenoid.bench.work_precision import table
from serpenoid.video.seeing.tags import tag_cells

MAX_DIFFERENCE = 2e-3  # mean difference of a colour, 0 to 1; rounding may change a pixel's shade


def mean_difference(image: np.ndarray, reference: np.ndarray) -> float:
    """Return the mean difference of two pictures, 0 to 1; 1 if their sizes differ."""
    if image.shape != reference.shape:
        return 1.0
    return float(np.abs(image[..., :3] - reference[..., :3]).mean())


@pytest.mark.slow
@pytest.mark.parametrize("name", figures.FIGURES)
def test_a_stored_figure_is_current(name, tmp_path) -> None:
    figures.FIGURES[name](tmp_path / name)
    drawn, stored = tmp_path / name, figures.STORED / name
    if name.endswith(".svg"):
        assert drawn.read_text() == stored.read_text()
    else:
        difference = mean_difference(imread(drawn), imread(stored))
        assert difference < MAX_DIFFERENCE, f"host/docs/{name} is stale: `make figures`"


def test_every_stored_picture_has_its_drawing() -> None:
    pictures = {
        path.name for suffix in ("png", "svg") for path in figures.STORED.glob(f"*.{suffix}")
    }
    assert pictures == set(figures.FIGURES)


def test_every_picture_of_a_page_is_in_the_repository() -> None:
    for page in (*(ROOT / "docs").glob("*.md"), ROOT / "README.md"):
        for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text()):
            assert (page.parent / name).exists(), f"{page.name}: {name}"


def test_drawn_tags_are_the_printed_ones() -> None:
    cells = np.array(tag_cells(len(film_pictures.PATTERNS)))[:, 1:-1, 1:-1].reshape(-1, 16)
    assert (cells @ (1 << np.arange(15, -1, -1)) == film_pictures.PATTERNS).all()


def test_the_table_of_the_documentation_is_that_of_the_kept_measurement() -> None:
    _, *lines = table(figures.measured_rows()).split("\n")  # the page's heads are words
    assert "\n".join(lines) in (figures.ROOT / "docs/benchmarks.md").read_text()
