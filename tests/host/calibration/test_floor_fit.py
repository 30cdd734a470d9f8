"""Pushes fitted, against an integration in small steps and a brute likelihood."""

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
    rolled_out,
    short_session,
)
from calibration.synthetic_session import WHOLE_BODY_2005
from calibration.synthetic_session import session as stations_session
from calibration.synthetic_session import setup as stations_setup
from refusals import refused
from serpenoid import Ground, Robot, fit_friction
from serpenoid.friction.bends import resistance
from serpenoid.friction.push_paths import push_paths
from serpenoid.friction.push_track import PushTrack
from serpenoid.friction.rolling_law import rest, way_m
from serpenoid.friction.slip import Slip, Start
from serpenoid.lab.floor import Floor, Push
from serpenoid.lab.recording import Camera, film
from serpenoid.lab.robot import LabRobot, pose_of
from serpenoid.model.bends import balanced_signs
from serpenoid.session.track import Track
from serpenoid.taking.track_look import look_at
from simulated_sessions import MemoryRecord


def one(*values):
    return [np.array([float(v)]) for v in values]


@pytest.mark.parametrize(("c", "f"), [(0.185, 0.31), (1e-9, 0.31), (3.0, 0.02), (0.0, 0.5)])
def test_the_law_is_the_integration(c, f):
    whole = (c * MASS, 0.0, f * MASS, 0.0)
    t, ways = rolled_out(0.8, whole)
    stop, way = np.ravel(rest(*one(0.8, c, f)))
    assert stop == pytest.approx(t[len(ways) - 4001], abs=2e-4)
    assert way == pytest.approx(ways[-1], abs=2e-6)
    at = np.linspace(0.0, stop + 0.3, 40)
    found, _, speed = way_m(at, np.full(40, 0.8), np.full(40, c), np.full(40, f))
    np.testing.assert_allclose(found, np.interp(at, t, ways), atol=2e-6)
    assert (speed[at > stop] == 0.0).all()


def mixed_session():
    """Pushes on film and to rest; stations: every term there is."""
    filmed = short_session()
    setup = replace(
        floor_setup(), instruments=replace(floor_setup().instruments, belt_scale_sigma_percent=2.0)
    )
    stations = stations_session(stations_setup(7.5, 30.0), WHOLE_BODY_2005)
    numbered = tuple(replace(r, number=100 + r.number) for r in stations.readings)
    record = MemoryRecord(
        setup, replace(stations, setup=setup, readings=numbered, further=filmed.further)
    )
    for way in ("there", "back"):
        t, x = rolled_out(0.8, TRUTH)
        cells = {"lambda_deg": 0.0, "way": way}
        record.add("push", cells | {"distance_m": x[-1], "duration_s": t[-4001]})
    return record.session


def test_pushes_tell_all_four_and_the_floor():
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


@pytest.mark.parametrize("bend_deg", [20.0, 45.0])
@pytest.mark.parametrize(("across", "crooked_deg", "turning_deg_s"), [(0.0105, 0, 0), (0, 2, -4)])
def test_a_slipping_push_goes_where_the_labs_rigid_body_goes(
    bend_deg, across, crooked_deg, turning_deg_s
):
    """On a floor that falls by 0.6 degrees, and let go crooked and turning."""
    bend, crooked, links = math.radians(bend_deg), math.radians(crooked_deg), 8
    whole, mass = np.array(TRUTH) * links / 6, MASS * links / 6
    lab = LabRobot.whole(Robot(links, MASS / 6, 0.076), Ground(*whole))
    push = Push(0.9, heading_rad=crooked, rate_rad_s=math.radians(turning_deg_s))
    track = Floor(lab, across_rad=across).push(pose_of(balanced_signs(links), bend), push)
    rolled = track.t_s >= track.released_s
    t_s, x_m, y_m = (v[rolled] - v[rolled][0] for v in (track.t_s, track.x_m, track.y_m))
    along, sideways, end = (
        [float(v) / mass for v in np.ravel(resistance(whole, share, np.array([angle])))]
        for share, angle in ((1.0, bend), (1.0, math.pi / 2 - bend), (0.5, 2 * bend))
    )
    law = one(0.9 * math.cos(crooked), *along)
    start = Start(-0.9 * math.sin(crooked), push.rate_rad_s)
    pull = 0.0, 9.81 * math.sin(across)
    ahead, left, turned = Slip(bend, sideways[0], *end).places(t_s, law, pull, start, crooked)
    place = (ahead + 1j * left) * np.exp(1j * crooked)
    np.testing.assert_allclose(place.real, x_m, atol=4e-4)
    np.testing.assert_allclose(place.imag, y_m, atol=4e-4)
    assert turned[-1] == pytest.approx(track.turned_rad, abs=2e-3)
    if across:
        assert ahead[-1] - rest(*law)[1][0] > 1e-3  # farther than without the slip
        seen = t_s[::3], x_m[::3], y_m[::3]
        assert "turned" in look_at(*seen).doubts[-1]
        assert not any("turned" in doubt for doubt in look_at(*seen, slips=True).doubts)


@pytest.mark.parametrize("links", [4, 8])
def test_a_robot_without_a_straight_link_slips_down_a_floor_that_falls_across(links):
    """The lab's robot is a rigid body on wheels, let go crooked and turning."""
    body, whole, across = Robot(links, MASS / 6, 0.076), np.array(TRUTH) * links / 6, 0.0105
    floor = Floor(LabRobot.whole(body, Ground(*whole)), across_rad=across)
    record = MemoryRecord(floor_setup(wheels_kg=0.0).with_robot(body))
    rng, camera = np.random.default_rng(3), Camera(sigma_m=5e-4)
    for bend in (0.0, 20.0, 45.0):
        pose = pose_of(balanced_signs(links), math.radians(bend))
        for way, direction in (("there", 0.0), ("back", math.pi)):
            for crooked in (-1.0, 0.0, 1.0):
                more = {"heading_rad": 0.03 * crooked * (-1) ** links, "rate_rad_s": 0.06 * crooked}
                track = floor.push(pose, Push(0.8, direction, **more))
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


def test_wheels_that_turn_are_not_friction():
    told = fit_friction(floor_session())
    ignored = fit_friction(floor_session(setup=floor_setup(wheels_kg=0.0)))
    assert ignored.whole_snake["ft0"] / told.whole_snake["ft0"] == pytest.approx(
        1 / 1.0595, rel=0.01
    )
    untold = fit_friction(floor_session(setup=floor_setup(wheels_kg=None)))
    assert any("wheels weigh" in note for note in untold.notes)
    assert untold.parameters["ft0"].sigma > 1.5 * told.parameters["ft0"].sigma


def test_one_way_only_is_as_sure_as_the_floor_is_level():
    both, single = (fit_friction(floor_session(ways=w)) for w in (("there", "back"), ("there",)))
    assert single.parameters["ft0"].sigma > 5 * both.parameters["ft0"].sigma
    assert any("one way" in note for note in single.notes)
    low, high = single.intervals["ft0"]
    assert low < FT0 < high


def test_stations_and_pushes_are_one_fit():
    session = mixed_session()
    together = fit_friction(session)
    alone = fit_friction(replace(session, further=()))
    for name in together.parameters:
        assert together.parameters[name].sigma < 1.001 * alone.parameters[name].sigma
    assert together.parameters["ct"].sigma < 0.8 * alone.parameters["ct"].sigma


def test_each_reading_has_its_own_residual_among_pushes_of_all_kinds():
    session = mixed_session()
    misread = next(push for push in session.kept_pushes if push.by == "rest")
    wrong = replace(misread, distance_m=1.3 * misread.distance_m)
    further = tuple(wrong if push == misread else push for push in session.further)
    fit = fit_friction(replace(session, further=further))
    assert session.fitted[int(np.argmax(np.abs(fit.residuals)))] == misread


def test_a_push_that_hit_something_is_named():
    session = floor_session(seed=2)
    first = session.further[0]
    hit = first.track.values * [1.0, 0.85, 0.85]
    wrong = replace(first, track=Track.of(first.track.columns, hit))
    session = replace(session, further=(wrong, *session.further[1:]))
    assert "Without reading 1 chi2" in fit_friction(session).alarms[0]
    off_m = [np.abs(push.residual_m).max() for push in push_paths(session)]
    assert max(off_m[1:]) < off_m[0]


def test_what_is_left_open_is_said_with_the_push_that_closes_it():
    with refused(r"cn and fn0 cannot be told.*bend of 42 degrees, both ways"):
        fit_friction(floor_session(bends_deg=(0.0,)))
    with refused("'naive' is the paper's, of stations alone"):
        fit_friction(floor_session(), method="naive")


def test_a_path_that_turns_feels_the_slope_where_it_heads():
    """One push integrated in small steps while it turns by 20 degrees, on a floor that falls."""
    pull, c, f, step = 0.05, 0.18, 0.3, 1e-4
    v, x, t, ways = 0.9, 0.0, 0.0, [0.0]
    while v > 0.0:
        heading = 0.35 * t / 2.4 - 0.1
        v, x, t = v - step * (c * v + f - pull * math.sin(heading)), x + step * v, t + step
        ways.append(x)
    at = np.arange(0.0, t + 0.3, 1 / 30)
    off_rad = 0.35 * at / 2.4 - 0.1
    way = np.interp(at, step * np.arange(len(ways)), ways)
    track = PushTrack(1, at, way, 0.001, 0.0, off_rad, "film")
    near = track.linear_about(np.array([0.19, 0.29, *np.zeros(6)]))
    left, level = (near.residuals(np.array([[c, f, 0.0, a, *np.zeros(4)]])) for a in (pull, 0.0))
    assert np.abs(left).max() < 0.03 * np.abs(left - level).max()
