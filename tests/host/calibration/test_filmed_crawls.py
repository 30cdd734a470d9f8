"""Filmed crawls: from a track to a reading, and crawls there and back on a floor that slopes."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from calibration.floor_sessions import TRUTH, floor_session, short_session
from calibration.test_dialogue import talk
from robots import OF_2005, gait_in_deg
from serpenoid import (
    Ground,
    compare,
    fit_friction,
    servo,
)
from serpenoid.friction.result import Estimate
from serpenoid.lab.crawl import crawl_speed
from serpenoid.lab.robot import LabRobot
from serpenoid.prediction.level import level_run
from serpenoid.session.crawls import Crawls
from serpenoid.session.gait_run import GaitRun
from serpenoid.taking.new_session import create_session, default_setup, on_place
from serpenoid.taking.procedure import Tracked, next_step, progress
from serpenoid.taking.simulated import crawl_cells

GAIT = gait_in_deg(70, 60, 2 * math.pi * 0.8)
GAINS, CENTRES_RAD, LAG_RAD = (0.95, 0.93, 0.97, 0.94, 0.96), (0.01, -0.02, 0.0, 0.03, 0.01), 0.4


def crawled(gait=GAIT):
    """Return what a film shows of joints that swing so, places and angles with scatter."""
    rng, omega = np.random.default_rng(1), gait.omega_rad_s
    t = np.arange(0.0, 5.0 * 2 * math.pi / omega, 1 / 30)
    way = 0.05 * t + 0.003 * np.sin(2 * omega * t)
    angles = [
        a + gait.alpha_rad * g * np.sin(omega * t + k * gait.beta_rad - LAG_RAD)
        for k, (g, a) in enumerate(zip(GAINS, CENTRES_RAD, strict=True))
    ]
    rows = np.stack([t, 0.6 * way, -0.8 * way, 0.02 * t, *angles], axis=1)
    rows[:, 1:3] += 0.0005 * rng.normal(size=(len(t), 2))
    rows[:, 4:] += 0.003 * rng.normal(size=(len(t), 5))
    return rows


def test_a_step_takes_the_film_of_a_crawl_once(tmp_path) -> None:
    def film(path, _, gait):
        rows = crawled(gait)
        return Tracked({**crawl_cells(rows, gait), "film_sha256": path.name}, rows, "video")

    base = default_setup("filmed")
    plan = replace(on_place(base.plan, "floor"), pushes=0)
    folder = create_session(tmp_path / "s", replace(base, plan=plan))
    names = "a.mp4", "a.mp4", "b.mp4", "c.mp4", "d.mp4"
    heard, session = talk(folder, *names, film=film)
    assert "reading 1 is of this film already" in heard
    assert "along the line of the pushes, BACK" in heard
    assert [f.way for f in session.kept_films] == ["there", "back"] * 2
    assert next_step(session).kind == "done"
    assert ("gait runs", "4 of 4") in progress(session)
    assert session.kept_films[0].gait.joint_gain == pytest.approx(GAINS, abs=5e-3)


SLOPE_RAD = 0.0045


@pytest.fixture(scope="module")
def sloped():
    """Return two runs by the lab's robot on 0.25 degrees, there and back, as of one command."""
    lab = LabRobot(OF_2005, (Ground.whole_body(6, *TRUTH),))
    return tuple(
        GaitRun(
            GAIT.alpha_rad,
            GAIT.beta_rad,
            (1.0 + 0.002 * k) * GAIT.omega_rad_s,
            crawl_speed(lab, GAIT, slope_rad=rises),
            0.0005,
            number=900 + k,
            way=way,
        )
        for k, (way, rises) in enumerate((("there", -SLOPE_RAD), ("back", SLOPE_RAD)))
    )


@pytest.mark.parametrize(
    ("gait", "along_rad", "across_rad", "moved_by"),
    [
        (GAIT, 0.0, 0.007, None),  # it turns downhill and goes faster there and back alike
        (gait_in_deg(80, 75, 2 * math.pi * 0.45), 0.005, 0.0, servo().servo),  # ripple helps uphill
    ],
)
def test_crawls_on_a_floor_that_slopes_are_put_right(gait, along_rad, across_rad, moved_by) -> None:
    lab = LabRobot(OF_2005, (Ground.whole_body(6, *TRUTH),), servo=moved_by)
    level = crawl_speed(lab, gait)
    runs = tuple(
        GaitRun(
            *(gait.alpha_rad, gait.beta_rad, gait.omega_rad_s),
            crawl_speed(lab, gait, slope_rad=-sign * along_rad, across_rad=sign * across_rad),
            0.0005,
            number=900 + int(sign),
            way=way,
        )
        for way, sign in (("there", 1.0), ("back", -1.0))
    )
    assert max(abs(run.speed_m_s / level - 1.0) for run in runs) > 0.05
    session = floor_session()
    session = replace(session, readings=(*session.readings, *runs))
    known = Estimate(along_rad, 1e-5), Estimate(across_rad, 1e-5)
    fit = replace(
        fit_friction(session),
        values=np.array(TRUTH),
        nuisances=dict(zip(("floor_slope_rad", "floor_slope_across_rad"), known, strict=True)),
    )
    for run in runs:
        brought, _ = level_run(session, fit, Crawls((run,)), run, moved_by)
        assert brought.speed_m_s == pytest.approx(level, rel=0.03)


def test_compare_holds_crawls_on_a_slope_to_the_prediction_for_level_ground(sloped) -> None:
    """The lab's crawls there and back are 8 % apart; no friction and no joint is to blame."""
    pushed = short_session(slope_rad=SLOPE_RAD)
    assert sloped[0].speed_m_s > 1.08 * sloped[1].speed_m_s
    found = compare(replace(pushed, readings=(*pushed.readings, *sloped)), servo=None, samples=32)
    assert found.verdict == "agrees"
    (fall_deg,) = re.findall(r"the floor falls by (.*) ± 0\.0.. deg on", found.verdict_text)
    assert float(fall_deg) == pytest.approx(math.degrees(SLOPE_RAD), abs=0.01)
    (once,) = found.gaits
    # pushes along one line do not tell by what the floor falls across it: up to 0.3 deg, as stated
    (across,) = re.findall(r"and by (\S+ ± \S+) deg to the left", found.verdict_text)
    assert [float(deg) for deg in across.split(" ± ")] == pytest.approx([0.0, 0.3], abs=0.01)
    assert abs(once.residual_m_s) < 2 * once.sigma_m_s
    level = replace(sloped[0], way="level")
    anywhere = compare(pushed.with_reading(level), servo=None, samples=32)
    assert "level ground" not in anywhere.verdict_text
