"""Fits of pushes that were simulated by small steps, or by the lab's rigid body."""

import math
from dataclasses import replace

import numpy as np
import pytest
from calibration.floor_sessions import (
    FT0,
    MASS,
    TRUTH,
    floor_session,
    floor_setup,
    short_session,
)
from calibration.synthetic_session import WHOLE_BODY_2005
from calibration.synthetic_session import session as stations_session
from calibration.synthetic_session import setup as stations_setup
from refusals import refused
from serpenoid import Ground, Robot, fit_friction
from serpenoid.lab.floor import Floor, Push
from serpenoid.lab.recording import Camera, film
from serpenoid.lab.robot import LabRobot, pose_of
from serpenoid.model.bends import balanced_signs
from simulated_sessions import MemoryRecord


def mixed_session():
    """Return filmed pushes, timed pushes and stations, so that all terms of the fit are used."""
    filmed = short_session()
    setup = replace(
        floor_setup(), instruments=replace(floor_setup().instruments, belt_scale_sigma_percent=2.0)
    )
    stations = stations_session(stations_setup(7.5, 30.0), WHOLE_BODY_2005)
    numbered = tuple(replace(r, number=100 + r.number) for r in stations.readings)
    record = MemoryRecord(
        setup, replace(stations, setup=setup, readings=(*numbered, *filmed.readings))
    )
    rest = {"lambda_deg": 0.0, "distance_m": 0.792, "duration_s": 2.117}
    for way in ("there", "back"):
        record.add("push", rest | {"way": way})
    return record.session


def test_pushes_give_all_four_frictions_and_the_slope():
    fit = fit_friction(floor_session())
    for (name, value), true in zip(fit.whole_snake.items(), TRUTH, strict=True):
        low, high = fit.intervals[name]
        assert low < true < high
        assert value == pytest.approx(true, rel=0.06)
    slope = fit.nuisances["floor_slope_rad"]
    assert slope.value == pytest.approx(0.003, abs=4 * slope.sigma)
    assert fit.p_value > 0.01
    assert len(fit.residuals) == len(fit.influence) == 12
    assert max(sigma / value for value, sigma in fit.parameters.values()) < 0.04


@pytest.mark.parametrize("links", [4, 8])
def test_a_bent_robot_shows_the_slope_across_the_track(links):
    """The lab's robot is a rigid body on wheels, released at an angle and with a rotation."""
    body, whole, across = Robot(links, MASS / 6, 0.076), np.array(TRUTH) * links / 6, 0.0105
    floor = Floor(LabRobot.whole_body(body, Ground(*whole)), across_rad=across)
    setup = floor_setup(wheels_kg=0.0)
    table = replace(setup.robot_table, links=links, mass_kg=body.mass_kg)
    record = MemoryRecord(replace(setup, robot_table=table))
    rng, camera = np.random.default_rng(3), Camera(sigma_m=5e-4)
    for bend in (0.0, 20.0, 45.0):
        pose = pose_of(balanced_signs(links), math.radians(bend))
        for way, direction in (("there", 0.0), ("back", math.pi)):
            for skew in (-1.0, 0.0, 1.0):
                start = {"heading_rad": 0.03 * skew * (-1) ** links, "rate_rad_s": 0.06 * skew}
                track = floor.push(pose, Push(0.8, direction, **start))
                rows = film(track, camera, rng)
                rows = rows[rows[:, 0] > track.released_s, :3]
                cells = {"lambda_deg": bend, "bend": "balanced", "way": way, "by": "film"}
                record.add("push", cells | {"distance_sigma_m": 5e-4}, samples=rows)
    fit = fit_friction(record.session)
    assert fit.p_value > 0.01
    for (value, sigma), true in zip(fit.parameters.values(), whole, strict=True):
        assert abs(value - true) < 2.0 * sigma
    assert fit.whole_snake["fn0"] == pytest.approx(whole[3], rel=0.08)
    slope = fit.nuisances["floor_slope_across_rad"]
    assert slope.value == pytest.approx(across, abs=2.0 * slope.sigma)
    assert slope.sigma < across / 4


def test_inertia_of_the_wheels_is_not_taken_for_friction():
    known = fit_friction(floor_session())
    without_wheels = fit_friction(floor_session(setup=floor_setup(wheels_kg=0.0)))
    assert without_wheels.whole_snake["ft0"] / known.whole_snake["ft0"] == pytest.approx(
        1 / 1.0595, rel=0.01
    )
    unknown = fit_friction(floor_session(setup=floor_setup(wheels_kg=None)))
    assert any("wheels weigh" in note for note in unknown.notes)
    assert unknown.parameters["ft0"].sigma > 1.5 * known.parameters["ft0"].sigma


def test_pushes_in_one_direction_leave_the_slope_unknown():
    session = floor_session()
    turned = replace(session.readings[0], way="back")
    fit = fit_friction(replace(session, readings=(turned, *session.readings[1:])))
    assert any("went the other way in the picture" in note for note in fit.notes)
    both, single = (fit_friction(floor_session(ways=w)) for w in (("there", "back"), ("there",)))
    assert single.parameters["ft0"].sigma > 5 * both.parameters["ft0"].sigma
    assert any("one way" in note for note in single.notes)
    low, high = single.intervals["ft0"]
    assert low < FT0 < high


def test_a_fit_combines_stations_and_pushes():
    session = mixed_session()
    together = fit_friction(session)
    alone = fit_friction(replace(session, readings=session.kept_stations))
    for name in together.parameters:
        assert together.parameters[name].sigma < 1.001 * alone.parameters[name].sigma
    assert together.parameters["ct"].sigma < 0.8 * alone.parameters["ct"].sigma


def test_a_refusal_names_the_missing_pushes():
    with refused(r"cn and fn0 cannot be told: in all .* straight; .*bend of 42 degrees, both ways"):
        fit_friction(floor_session(bends_deg=(0.0,)))
    with refused("'naive' is the paper's, of stations alone"):
        fit_friction(floor_session(), method="naive")
