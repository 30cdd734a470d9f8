"""What each friction's doubt leaves of a speed: differences of solved speeds say the same."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from serpenoid.calibration.advising.speed_doubts import speed_doubts
from serpenoid.calibration.speed_samples import SpeedBand, speed_band
from serpenoid.commands.demo import session_folder


@pytest.fixture(scope="module")
def fit() -> sn.FrictionFit:
    return sn.fit_friction(sn.load_session(session_folder()))


def doubts(fit: sn.FrictionFit, hz: float) -> Any:
    gait = sn.Gait(math.radians(70), math.radians(75), math.tau * hz)
    state = sn.steady_gait(fit.robot, fit.ground, gait, sensitivities=True)
    assert state.sensitivities is not None
    return speed_doubts(fit, state.sensitivities, speed_band(fit, gait, servo=None))


def speed_at(fit: sn.FrictionFit, hz: float, whole: np.ndarray) -> float:
    ground = sn.Ground.whole_body(fit.robot.links, *whole.tolist())
    gait = sn.Gait(math.radians(70), math.radians(75), math.tau * hz)
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
    # the largest part first, and all of them together as draws say
    assert found.straight
    first = max(found.each, key=found.each.__getitem__)
    assert f"derivatives): {first} ±" in found.in_words()
    assert "mislead" not in found.in_words()


def test_near_a_cliff_it_says_that_derivatives_mislead(fit) -> None:
    """Wheels that hold now slip at a little less grip: the speed's slope tells nothing of it."""
    found = doubts(fit, 0.25)
    assert found.drawn > 5 * found.together
    assert not found.straight
    assert "Derivatives mislead here: the draws count." in found.in_words()


def test_a_ratchets_frictions_both_ways_and_one_that_is_0() -> None:
    values = {"ct": 0.1, "cn": 1.0, "ft0": 0.0, "fn0": 0.3, "ct_back": 0.2, "ft0_back": 0.4}
    parts = {"ct_forward": 1.0, "ct_backward": 2.0, "cn": 3.0, "ft0_backward": 4.0, "fn0": 5.0}
    covariance = np.diag([1e-4 * v**2 for v in values.values()])
    fit: Any = SimpleNamespace(names=tuple(values), whole_snake=values, covariance=covariance)
    found: Any = SimpleNamespace(
        names=tuple(parts), elasticities=lambda: np.array(list(parts.values())), at=[0.1]
    )
    told = speed_doubts(fit, found, SpeedBand(0.1, 0.09, 0.11, 0.09, 0.11))
    each = {"ct": 0.01, "cn": 0.03, "ft0": 0.0, "fn0": 0.05, "ct_back": 0.02, "ft0_back": 0.04}
    assert told.each == pytest.approx(each)
    assert told.together == pytest.approx(0.01 * math.sqrt(1 + 4 + 9 + 16 + 25))


def test_the_command_tells_it_with_a_fit_and_derivatives_alone(serpenoid) -> None:
    typed = ("steady", "--alpha-deg", "70", "--beta-deg", "75", "--frequency-hz", "1", "--servo",
             "ideal", "--json", "--sensitivities")  # fmt: skip
    session = ("--session", str(session_folder()))
    told = json.loads(serpenoid(*typed, *session)[1])["doubts"]
    assert set(told) == {"each", "together", "drawn", "straight"}
    for other in (typed, (*typed[:-1], *session), (*typed, *session, "--fn0", "0.05")):
        assert "doubts" not in json.loads(serpenoid(*other)[1])
