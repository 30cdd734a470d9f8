"""Ratchet wheels on a floor: pushed tail first, too, and both frictions fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from calibration.floor_sessions import TRUTH, floor_session, floor_setup, push_track
from serpenoid import Gait, Ground, fit_friction
from serpenoid.calibration.friction_result import ground_of
from serpenoid.calibration.kinds.gait import GaitRun
from serpenoid.calibration.speeds import speed
from serpenoid.calibration.taking.expected import Series, of_series, series_of_pushes
from serpenoid.calibration.taking.procedure import next_step, progress
from serpenoid.calibration.taking.simulated import SimulatedPerson
from serpenoid.calibration.taking.treadmill import take_all
from serpenoid.calibration.taking.world import Truth
from simulated_sessions import MemoryRecord

CT_BACK, FT0_BACK = 0.3, 0.4
ALL = (*TRUTH, CT_BACK, FT0_BACK)


def check_holds(fit):
    assert fit.names == ("ct", "cn", "ft0", "fn0", "ct_back", "ft0_back")
    for name, true in zip(fit.names, ALL, strict=True):
        low, high = fit.intervals[name]
        assert low < true < high
        assert high - low < 0.35 * true


def with_backward(session, ways=("there", "back"), speeds=(0.7, 0.8, 0.9, 1.0)):
    """Return the session with straight pushes tail first, by the reference's own integration."""
    rng, record = np.random.default_rng(9), MemoryRecord(session.setup, session)
    for k, v0 in enumerate(speeds):
        way = ways[k % len(ways)]
        slope = 0.003 * (1 if way == "there" else -1)
        whole = (CT_BACK, TRUTH[1], FT0_BACK, TRUTH[3])
        track = push_track(v0, whole, rng, slope_rad=slope, rolling=0.0595)
        cells = {
            "lambda_deg": 0.0,
            "facing": "back",
            "way": way,
            "by": "film",
            "distance_sigma_m": 0.001,
        }
        record.add("push", cells, samples=track)
    return record.session


def test_pushes_tail_first_tell_the_backward_frictions_and_no_other() -> None:
    session = floor_session()
    before, fit = fit_friction(session), fit_friction(with_backward(session))
    check_holds(fit)
    for name in before.names:
        assert abs(fit.whole_snake[name] - before.whole_snake[name]) < before.parameters[name].sigma
    assert fit.ground.ct != before.ground.ct


def test_crawls_are_fitted_with_the_backward_frictions() -> None:
    session = with_backward(floor_session(bends_deg=(0.0, 45.0)))
    robot, gait = session.setup.robot, Gait(1.2, 1.0, 5.0)
    crawled = speed(robot, ground_of(robot.links, ALL), gait)
    run = GaitRun(90, gait.alpha_rad, gait.beta_rad, gait.omega_rad_s, crawled, 1e-3)
    fit = fit_friction(replace(session, gait_runs=(run,)), crawls=True)
    check_holds(fit)
    pushed = np.linalg.det(fit_friction(session).covariance)
    assert np.linalg.det(fit.covariance) < 0.8 * pushed


def test_the_plan_of_a_ratchet_asks_for_both_and_a_person_can_do_it() -> None:
    base = floor_setup()
    setup = replace(base, procedure=replace(base.procedure, ratchet=True, pushes=2))
    assert [s.facing for s in series_of_pushes(setup.procedure)[:2]] == ["ahead", "back"]
    assert {s.facing for s in series_of_pushes(base.procedure)} == {"ahead"}
    ground = Ground((TRUTH[0], CT_BACK), TRUTH[1], (TRUTH[2], FT0_BACK), TRUTH[3])
    taken = take_all(MemoryRecord(setup), SimulatedPerson(setup, Truth(ground), 3))
    tail = of_series(taken, Series(0.0, "back"))
    assert [p.way for p in tail] == ["there", "back"]
    assert max(p.counted[0][-1] for p in tail) < min(
        p.counted[0][-1] for p in of_series(taken, Series(0.0, "ahead"))
    )  # they brake harder
    assert ("pushes, straight", "2 of 2") in progress(taken)
    started = MemoryRecord(setup).session
    assert "head first" in next_step(started, posed_deg=0.0).say
    done = replace(taken, further=tuple(p for p in taken.further if p not in tail))
    assert "TAIL FIRST" in next_step(done, posed_deg=0.0).say
