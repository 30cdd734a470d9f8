"""Figures: turned runs keep their shape, every axis has a unit, every picture shows something."""

from __future__ import annotations

import matplotlib.image
import numpy as np
import pytest
import serpenoid as sn
from matplotlib.figure import Figure
from robots import NIRAKH_2005
from serpenoid.paper.study import PATH_GAIT, path_run
from serpenoid.show import plot


@pytest.fixture(scope="module")
def run() -> sn.Run:
    return path_run(PATH_GAIT, 3)


@pytest.fixture
def drawn(monkeypatch) -> list[Figure]:
    """Return the figures that are saved, as they are."""
    figures: list[Figure] = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda self, p: (figures.append(self), save(self, p)))
    return figures


@pytest.mark.parametrize("name", ["friction", "formulations", "path"])
def test_every_figure_has_units_and_ink(name, run, tmp_path, drawn) -> None:
    path = tmp_path / f"{name}.png"
    if name == "friction":
        session = sn.load_session(NIRAKH_2005)
        sn.fit_friction(session).plot(path, session=session)
    elif name == "formulations":
        rates_hz = np.array([1.0, 2.0])
        plot.formulations_figure(rates_hz, 0.1 * rates_hz, 0.099 * rates_hz, "title", path)
    else:
        plot.path_and_poses(run, "title", path)
    for ax in drawn[0].axes:
        labels = [ax.get_xlabel(), ax.get_ylabel()]
        assert any(labels)
        assert all(text.endswith(("(m/s)", "(N)", "(Hz)", "(%)", "(m)")) for text in labels if text)
    pixels = matplotlib.image.imread(path)[:, :, :3]
    assert min(pixels.shape[:2]) >= 600  # dots: sharp on a page
    ink = float((pixels.min(axis=2) < 0.9).mean())
    assert 0.01 < ink < 0.5
