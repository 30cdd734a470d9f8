"""Break-away checks: told beside the fit, and never a part of it."""

from __future__ import annotations

import math

import pytest
from calibration.floor_sessions import FN0, FT0, MASS, G, short_session
from serpenoid import fit_friction
from serpenoid.calibration.kinds.slide import BreakAway
from serpenoid.prediction.break_away import break_away_notes, ratio


@pytest.fixture(scope="module")
def session():
    return short_session()


def checked(session, share, lambda_rad=0.0):
    c, s = math.cos(lambda_rad), math.sin(lambda_rad)
    force = FT0 * (2 + 4 * c) / 6 + FN0 * 4 * s / 6
    tilt = math.asin(share * force / (MASS * G))
    made = [BreakAway(900 + k, lambda_rad, tilt, "balanced") for k in range(3)]
    for one in made:
        session = session.with_reading(one)
    return session, made


@pytest.mark.parametrize("lambda_rad", [0.0, math.pi / 4])
def test_the_share_is_found_and_the_fit_is_the_same(session, lambda_rad) -> None:
    fit = fit_friction(session)
    grown, made = checked(session, 1.5, lambda_rad)
    value, sigma = ratio(fit, grown, made)
    assert value == pytest.approx(1.5, abs=2 * sigma)
    assert fit_friction(grown).whole_snake == fit.whole_snake
    assert grown.sha256 == session.sha256
    assert "may crawl faster" in break_away_notes(fit, grown)[0]


def test_no_difference_and_an_impossible_one_are_told(session) -> None:
    fit = fit_friction(session)
    assert "no difference" in break_away_notes(fit, checked(session, 1.0)[0])[0]
    assert "zero" in break_away_notes(fit, checked(session, 0.5)[0])[0]
    assert break_away_notes(fit, session) == ()
