"""Figures: turned runs keep their shape, every axis has a unit, every picture shows something."""

from __future__ import annotations

from types import SimpleNamespace

import matplotlib.image
import pytest
import serpenoid as sn
from matplotlib.figure import Figure
from robots import NIRAKH_2005, PAPER, VISCOUS, gait_in_deg
from serpenoid.prediction.predict import one_cycle
from serpenoid.show import plot


@pytest.fixture(scope="module")
def run() -> sn.Run:
    gait = gait_in_deg(30, 80, 5.0)
    return one_cycle(PAPER, VISCOUS, gait)[1]


def _points() -> list[SimpleNamespace]:
    names = "frequency_hz", "explicit_m_s", "implicit_m_s"
    return [
        SimpleNamespace(**dict(zip(names, (f, 0.1 * f, 0.099 * f), strict=True))) for f in (1, 2)
    ]


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
        plot.friction_lines(session, sn.fit_friction(session), path)
    elif name == "formulations":
        plot.formulations_figure(_points(), "title", path)
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
