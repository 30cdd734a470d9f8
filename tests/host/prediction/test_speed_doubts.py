"""What each friction's doubt leaves of a speed: differences of solved speeds say the same."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from robots import gait_in_deg
from serpenoid.calibration.friction_result import FitDraws
from serpenoid.calibration.speeds import MODEL_SIGMA
from serpenoid.commands.demo import session_folder
from serpenoid.prediction import speed_doubts as room
from serpenoid.prediction.speed_doubts import speed_doubts
from serpenoid.prediction.speed_samples import SpeedBand, speed_band


@pytest.fixture(scope="module")
def fit() -> sn.FrictionFit:
    return sn.fit_friction(sn.load_session(session_folder()))


def doubts(fit: sn.FrictionFit, hz: float) -> Any:
    gait = gait_in_deg(70, 75, math.tau * hz)
    state = sn.steady_gait(fit.robot, fit.ground, gait, sensitivities=True)
    assert state.sensitivities is not None
    return speed_doubts(fit, gait, state.sensitivities, speed_band(fit, gait, servo=None))


def speed_at(fit: sn.FrictionFit, hz: float, whole: np.ndarray, amplitude: float = 1.0) -> float:
    ground = sn.Ground.whole_body(fit.robot.links, *whole.tolist())
    gait = sn.Gait(amplitude * math.radians(70), math.radians(75), math.tau * hz)
    return sn.steady_gait(fit.robot, ground, gait, rtol=1e-7, powers=False).speed_m_s


def test_each_friction_is_worth_what_a_step_of_it_changes(fit) -> None:
    found = doubts(fit, 1.0)
    whole = np.array(list(fit.whole_snake.values()))
    sigma = np.sqrt(np.diag(fit.covariance))
    here = speed_at(fit, 1.0, whole)
    for k, name in enumerate(fit.names):
        step = 0.01 * sigma[k] * np.eye(4)[k]
        ends = [speed_at(fit, 1.0, whole + sign * step) for sign in (1, -1)]
        assert found.each[name] == pytest.approx(abs(ends[0] - ends[1]) / 0.02 / here, rel=0.03)
    ends = [speed_at(fit, 1.0, whole, 1 + 3e-4 * sign) for sign in (1, -1)]
    expected = abs(ends[0] - ends[1]) / 0.02 / here
    assert found.each["amplitude"] == pytest.approx(expected, rel=0.03)
    # the largest part first, and all of them together as draws say
    assert found.straight
    first = max(found.each, key=found.each.__getitem__)
    assert found.rows()[0][0] == f"{first} alone"
    assert found.each_drawn[first] == pytest.approx(found.each[first], rel=0.1)
    assert found.shares["servos"] == 0  # there are none, and no row of them
    assert [row[0] for row in found.rows()[5:]] == ["all frictions", "with the joints' amplitude"]
    assert "mislead" not in found.in_words()


def test_near_a_cliff_it_says_that_derivatives_mislead(fit) -> None:
    """Wheels that hold now slip at a little less grip: the speed's slope tells nothing of it."""
    found = doubts(fit, 0.25)
    assert found.drawn > 5 * found.together
    assert found.each["fn0"] < found.each["amplitude"]  # the least grip is far from this
    assert found.rows()[0][0] == "fn0 alone"  # but not from what the readings allow
    assert found.each_drawn["fn0"] > 5 * found.each["fn0"]
    assert not found.straight
    assert "Derivatives mislead here: the draws count." in found.in_words()


VALUES = {"ct": 0.1, "cn": 1.0, "ft0": 0.0, "fn0": 0.3}
PARTS = {
    "ct": 1.0,
    "cn": 3.0,
    "fn0": 5.0,
    "alpha_rad": 6.0,
}


@pytest.fixture
def told(monkeypatch) -> Any:
    """Return the doubts of a fit whose frictions are known to 1 %, but for what changes."""
    monkeypatch.setattr(room, "_alone", lambda *_: np.zeros((5, 64)))
    covariance = np.diag([1e-4 * v**2 for v in VALUES.values()])
    found: Any = SimpleNamespace(
        names=tuple(PARTS), elasticities=lambda: np.array(list(PARTS.values())), at=[0.1]
    )

    def of(filmed: bool = False, draws: np.ndarray | None = None) -> room.SpeedDoubts:
        fit: Any = SimpleNamespace(
            names=tuple(VALUES),
            whole_snake=VALUES,
            covariance=covariance,
            with_crawls=draws is not None,
            draws=draws is not None and FitDraws((*VALUES, "amplitude"), draws),
        )
        ends = (0.07, 0.13, 0.09, 0.11, 0.08, 0.12)
        return speed_doubts(fit, sn.Gait(1, 1, 1), found, SpeedBand(0.1, *ends, filmed=filmed))

    return of


def test_a_friction_that_is_0_has_no_doubt(told) -> None:
    each = {"ct": 0.01, "cn": 0.03, "ft0": 0.0, "fn0": 0.05}
    assert told().each == pytest.approx(each | {"amplitude": 0.18})
    together = 1 + 9 + 25
    assert told().together == pytest.approx(0.01 * math.sqrt(together))
    assert told().with_amplitude == pytest.approx(0.01 * math.sqrt(together + 18**2))


def test_friction_amplitude_and_servos_are_shares_of_one_variance(told) -> None:
    assert told().shares == pytest.approx({"friction": 1 / 9, "amplitude": 3 / 9, "servos": 5 / 9})
    assert told().in_words().startswith("most of it: servos, 56 % of the variance by draws")


def test_an_amplitude_that_a_film_showed_is_in_no_doubt(told) -> None:
    assert told(filmed=True).each["amplitude"] == 0
    assert told(filmed=True).with_amplitude == told().together


def test_what_crawls_told_of_friction_and_amplitude_together_counts(told) -> None:
    """Crawls know a speed better than what makes it: more grip goes with less amplitude."""
    rng = np.random.default_rng(3)
    grip = rng.normal(size=4096)
    draws = np.tile([*VALUES.values(), 1.0], (4096, 1))
    draws[:, 3] *= 1 + 0.06 * grip  # of fn0, whose elasticity is 5
    draws[:, 4] *= 1 - 0.05 * grip  # of the amplitude, whose is 6
    assert told(draws=draws).each["amplitude"] == pytest.approx(0.3, rel=0.05)
    assert told(draws=draws).with_amplitude == pytest.approx(MODEL_SIGMA, rel=1e-4)
    assert told(draws=draws).rows()[-2][0] == "with the joints' amplitude and the model's 1.5 %"
    assert told().rows()[-2][0] == "with the joints' amplitude"


def test_a_gait_at_the_end_of_its_range_has_a_band(fit) -> None:
    """Joints that go further than told stop at half a turn."""
    gait = sn.Gait(math.pi, math.radians(75), math.pi)
    state = sn.steady_gait(fit.robot, fit.ground, gait, sensitivities=True)
    assert state.sensitivities is not None
    band = speed_band(fit, gait, servo=None, count=16)
    found = speed_doubts(fit, gait, state.sensitivities, band)
    assert found.each["amplitude"] == 0  # no derivative: one side is shut
    assert found.each_drawn["amplitude"] > 0
