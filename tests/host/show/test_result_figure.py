"""`.plot()` of each result that has a figure: named axes, and the file that was asked for."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
import serpenoid as sn
from robots import BINGHAM, NIRAKH_2005, OF_2005, gait_in_deg

GAIT = gait_in_deg(70, 75, 4.0)
SESSION = sn.load_session(NIRAKH_2005)
UNITS = "(m/s)", "(N)", "(Hz)", "(W)", "(m)", "(s)", "(J)"
RATES = np.linspace(2.0, 6.0, 5)


def grid(betas: int) -> sn.Sweep:
    shape = {"alpha_rad": [1.2], "beta_rad": np.linspace(1.2, 1.4, betas)}
    return sn.sweep(OF_2005, BINGHAM, **shape, omega_rad_s=RATES)


@pytest.mark.parametrize(
    ("result", "drawn"),
    [
        (lambda: sn.simulate(sn.Scene(OF_2005, BINGHAM, GAIT, duration_s=2.0)), "path over"),
        (lambda: grid(1), "speed (m/s)"),
        (lambda: grid(9), "power (W)"),
        (lambda: sn.steady_gait(OF_2005, BINGHAM, GAIT), "net power (W)"),
        (lambda: sn.fit_friction(SESSION), "Along the links"),
        (lambda: sn.compare(SESSION, gaits=[GAIT], servo=None, samples=16), "speed (m/s)"),
    ],
    ids=["Run", "Sweep over frequency", "Sweep of shapes", "Steady", "FrictionFit", "Comparison"],
)
def test_each_result_is_printed_and_has_its_figure(result, drawn: str, tmp_path: Path) -> None:
    """Every axis has its unit; the picture is sharp, and shows something."""
    path, shown = tmp_path / "figure.png", result()
    assert str(shown).startswith(shown.in_words()[:80])
    axes = shown.plot(path).axes
    assert any(drawn in ax.get_title("left") + ax.get_ylabel() for ax in axes)
    for ax in axes:
        labels = [*filter(None, (ax.get_xlabel(), ax.get_ylabel()))]
        assert labels
        assert all(text.endswith(UNITS) for text in labels), labels
        assert ax.lines or ax.collections
    pixels = matplotlib.image.imread(path)[:, :, :3]
    assert min(pixels.shape[:2]) >= 600
    assert 0.01 < (pixels.min(axis=2) < 0.9).mean() < 0.5


def test_a_states_curve_over_frequency_passes_through_the_state() -> None:
    state = sn.steady_gait(OF_2005, BINGHAM, GAIT)
    for ax, value in zip(state.plot().axes, (state.speed_m_s, state.power_w), strict=True):
        curve, dot = ax.lines
        assert dot.get_ydata() == [pytest.approx(value)]
        here = np.interp(dot.get_xdata(), *curve.get_data())
        assert here == pytest.approx(value, rel=1e-3)
