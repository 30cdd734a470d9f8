"""Readings taken facing up and down the belt: friction forwards and backwards."""

from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from calibration import synthetic_session as synthetic
from refusals import refused
from serpenoid import Session

AHEAD = synthetic.WHOLE_BODY_2005
BACK = sn.Ground(ct=0.35, cn=1.2, ft0=0.42, fn0=0.27)
WANTED = {"ct": 0.084, "cn": 1.2, "ft0": 0.14, "fn0": 0.27, "ct_back": 0.35, "ft0_back": 0.42}
SETUP = synthetic.setup(15.0)


def both_ways(seed: int | None = None, bent_back: bool = True) -> Session:
    """Return a session read facing down, then facing up; one zero of the inclinometer for both."""
    down, up = (
        synthetic.session(SETUP, truth, seed and np.random.default_rng(seed))
        for truth in (AHEAD, BACK)
    )
    kept = [r for r in up.readings if bent_back or r.lambda_rad == 0]
    readings = [*down.readings, *(replace(r, facing="up") for r in kept)]
    return replace(down, readings=tuple(replace(r, number=k + 1) for k, r in enumerate(readings)))


@pytest.mark.parametrize("method", ["joint", "naive"])
def test_readings_without_errors_give_the_truth(method: str) -> None:
    fit = sn.fit_friction(both_ways(), method=method)
    assert fit.whole_snake == pytest.approx(WANTED, rel=1e-5)
    ct, cn, ft0, fn0, *back = (fit.parameters[name].value for name in WANTED)
    assert fit.ground == sn.Ground.whole_body(6, (ct, back[0]), cn, (ft0, back[1]), fn0)
    assert fit.ground.ratchet
    assert fit.covariance.shape == (6, 6)
    assert [row.name for row in fit.rows()][4:] == ["ct_back_whole", "ft0_back_whole"]


def test_bent_readings_one_way_are_enough() -> None:
    fit = sn.fit_friction(both_ways(bent_back=False))
    assert fit.whole_snake == pytest.approx(WANTED, rel=1e-5)


@pytest.mark.parametrize(
    ("keeps", "said"),
    [
        (lambda r: r.facing == "up", "ct and ft0 cannot be told from 0 straight"),
        (lambda r: r.facing == "down" or r.lambda_rad > 0, "ct_back and ft0_back cannot be told"),
    ],
)
def test_a_way_that_was_not_read_is_named(keeps, said: str) -> None:
    session = both_ways()
    kept = tuple(r for r in session.readings if keeps(r))
    with refused(said):
        sn.fit_friction(replace(session, readings=kept))
    with refused("facing is 'left'"):
        replace(session.readings[0], facing="left")


def test_a_reading_is_typed_and_kept_with_its_facing() -> None:
    from serpenoid.calibration.kinds.rows import READING_COLUMNS, make_reading, reading_row
    from serpenoid.calibration.taking.parse_number import read_cells

    cells = ["lambda_deg=0", "incline_deg=3", "belt_speed_m_s=0.2"]
    plain = reading_row("station", read_cells("station", cells, SETUP))
    assert plain["more"] == ""
    assert make_reading(plain, {"number": 1}).facing == "down"
    row = reading_row("station", read_cells("station", [*cells, "facing=up"], SETUP))
    assert row["more"] == "facing=up"
    assert set(row) == set(READING_COLUMNS)
    assert make_reading(row, {"number": 1}).facing == "up"
    with refused("facing is 'sideways'"):
        make_reading(row | {"more": "facing=sideways"}, {"number": 1})
