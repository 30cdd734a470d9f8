"""What all readings share: belt scale, mass, straightness; and what makes a fit no ground."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from calibration.synthetic_session import WHOLE_BODY_2005, session, setup
from command_line import serpenoid
from simulated_sessions import MemoryRecord

NAMES = ("ct", "cn", "ft0", "fn0")
NO_BELT = "The belt's speed was not checked"


def stating(made, **sigmas):
    unsure = replace(made.setup.instruments, **sigmas)
    return replace(made, setup=replace(made.setup, instruments=unsure))


def checked(made, distance_m, duration_s):
    """Return a session with a mark on its belt timed while it shows 0.5 m/s."""
    record = MemoryRecord(made.setup, made)
    cells = {"belt_speed_m_s": 0.5, "distance_m": distance_m, "duration_s": duration_s}
    record.add("belt", cells)
    return record.session


def belt_as_stated(made):
    """Return a session whose belt is taken to run as its instruments say."""
    regenerated = replace(made.setup.provenance, kind="regenerated")
    return replace(made, setup=replace(made.setup, provenance=regenerated))


def test_scales_add_in_quadrature_and_a_mark_on_the_belt_tells():
    made = belt_as_stated(session(setup(15.0, 30.0), WHOLE_BODY_2005))
    plain = sn.fit_friction(made)
    shared = sn.fit_friction(stating(made, belt_scale_sigma_percent=10.0, mass_sigma_percent=5.0))
    for name, belt in zip(NAMES, (0.1, 0.1, 0.0, 0.0), strict=True):
        (value, before), (same, after) = plain.parameters[name], shared.parameters[name]
        assert same == pytest.approx(value, rel=1e-9)
        assert after**2 == pytest.approx(
            before**2 + (belt * value) ** 2 + (0.05 * value) ** 2,
            rel=0.1,  # of draws, twice
        )
        assert shared.intervals[name][1] > plain.intervals[name][1]
    # it runs 10 % faster than it shows
    told = checked(stating(made, belt_scale_sigma_percent=10.0), 11.0, 20.0)
    scale, sigma = told.belt_scale
    assert (scale, sigma) == (pytest.approx(1.1, abs=0.003), pytest.approx(0.011, rel=0.1))
    fit = sn.fit_friction(told)
    assert fit.parameters["cn"].value == pytest.approx(
        plain.parameters["cn"].value / scale, rel=1e-6
    )
    assert fit.parameters["ft0"].value == pytest.approx(plain.parameters["ft0"].value, rel=1e-6)


def test_a_belt_that_nobody_checked_is_as_unsure_as_any_belt():
    made = session(setup(15.0, 30.0), WHOLE_BODY_2005)
    fit = sn.fit_friction(made)
    ct, ft0 = fit.parameters["ct"], fit.parameters["ft0"]
    assert ct.sigma / ct.value > 0.07 > ft0.sigma / ft0.value
    assert NO_BELT in " ".join(fit.unmeasured)
    told = checked(made, 28.0, 56.0)
    assert told.belt_scale[1] < 0.01
    assert NO_BELT not in " ".join(sn.fit_friction(told).unmeasured)


def test_links_off_their_path_cost_dry_friction_and_the_fit_knows():
    """What straight links drag by their mean angle is taken off ft0, and adds to its error."""
    made, sigma = session(setup(15.0, 30.0), WHOLE_BODY_2005), math.radians(1.5)
    angles = np.cumsum(np.random.default_rng(1).normal(0.0, sigma, (6, 20_000)), axis=0)
    steered = np.polynomial.polynomial.polyfit(np.arange(6), angles, 1)  # heading and curvature
    off = angles.T - np.polynomial.polynomial.polyval(np.arange(6), steered)
    more = WHOLE_BODY_2005.fn0 * np.abs(off).mean() / made.setup.weight_n
    dragged = replace(
        made,
        readings=tuple(
            replace(r, incline_rad=r.incline_rad + more * (not r.lambda_rad)) for r in made.readings
        ),
    )
    fit, plain = (
        sn.fit_friction(stating(dragged, joint_sigma_deg=math.degrees(sigma))),
        sn.fit_friction(made),
    )
    assert fit.whole_snake["ft0"] == pytest.approx(WHOLE_BODY_2005.ft0, rel=2e-3)
    assert fit.parameters["ft0"].sigma > 1.01 * plain.parameters["ft0"].sigma


def test_friction_that_falls_with_speed_and_slippery_bends_are_alarms():
    made = session(setup(15.0), WHOLE_BODY_2005)
    falling = [
        replace(r, incline_rad=2 * made.readings[0].incline_rad - r.incline_rad + 0.02)
        if not r.lambda_rad
        else r
        for r in made.readings
    ]
    fit = sn.fit_friction(replace(made, readings=tuple(falling)))
    assert any("straight robot falls with speed" in alarm for alarm in fit.alarms)
    slippery = [
        replace(r, incline_rad=r.incline_rad / 2) if r.lambda_rad else r for r in made.readings
    ]
    fit = sn.fit_friction(replace(made, readings=tuple(slippery)))
    assert any("less friction than the straight one" in alarm for alarm in fit.alarms)
    assert sn.fit_friction(made).alarms == ()
    few = replace(made, readings=(*made.readings[:2], *made.readings[-2:]))
    assert any("no degree of freedom" in note for note in sn.fit_friction(few).notes)


def test_every_prediction_notes_what_was_not_measured(tmp_path):
    folder = tmp_path / "asked"
    serpenoid(f"calibrate new {folder} --defaults --surface belt", check=True)
    for bend, incline, belt in ((0, 2, 0.3), (0, 3, 1.0), (15, 3.0, 0.1), (15, 4.0, 0.5)):
        cells = f"lambda_deg={bend} incline_deg={incline} belt_speed_m_s={belt}"
        serpenoid(f"calibrate add {folder} station {cells}", check=True)
    gait = "--alpha-deg 70 --beta-deg 75 --frequency-hz 0.5"
    done = serpenoid(f"steady {gait} --servo ideal --robot {folder} --json")
    weight, zero, belt = json.loads(done.stdout)["fit_notes"]
    assert weight.startswith("The robot was not weighed")
    assert "0 ± 0.5 degrees are assumed, which is ± 0.039 N of ft0" in zero
    assert belt.startswith(NO_BELT)
    assert f"note: {zero}" in done.stderr
