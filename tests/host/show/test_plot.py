"""Figures: turned runs keep their shape, every axis has a unit, every picture shows something."""

from __future__ import annotations

import matplotlib.image
import numpy as np
import pytest
import serpenoid as sn
from matplotlib.figure import Figure
from robots import NIRAKH_2005, PAPER, VISCOUS, gait_in_deg
from serpenoid.prediction.predict import SpeedPoint, one_cycle
from serpenoid.show import plot


@pytest.fixture(scope="module")
def run() -> sn.Run:
    gait = gait_in_deg(30, 80, 5.0)
    return one_cycle(PAPER, VISCOUS, gait)[1]


def _points() -> list[SpeedPoint]:
    speeds = np.outer([0.5, 1.0, 2.0], [1.0, 0.08, 0.12, 0.09, 0.11, 0.099, 0.095])
    return [
        SpeedPoint(f, 0.1 * f, 1e-8, *others, 1e-6, 1.0, typical, 1.2)
        for f, *others, typical in speeds.tolist()
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


def test_a_ratchet_is_named_both_ways(run) -> None:
    ground = sn.Ground((0.014, 0.05), 0.2, (0.02, 0.06), 0.045)
    words = plot.robot_words(run.scene.robot, ground)
    assert "ct 0.084/0.3, cn 1.2 N s/m, ft0 0.12/0.36, fn0 0.27 N" in words
