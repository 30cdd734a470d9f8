"""The page of `serpenoid view`: its numbers are the run's, and a browser draws them."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
import serpenoid as sn
from click.testing import CliRunner
from serpenoid.commands.main import cli
from serpenoid.show.pages.view_page import of_run, write_page
from webdriver import Browser

GAIT = sn.Gait(math.radians(70), math.radians(75), 5.0)
GROUND = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("view") / "virtual.html"
    done = CliRunner().invoke(cli, ["view", "virtual", "--out", str(path)])
    assert done.exit_code == 0, done.output
    return path


def data(page: Path) -> dict:
    text = page.read_text()
    return json.loads(re.search(r'type="application/json">(.*?)</script>', text, re.S)[1])


def test_a_run_is_shown_as_it_is() -> None:
    scene = sn.Scene(sn.Robot(6, 0.0756, 0.076), GROUND, GAIT, start="steady", method="nonsmooth",
                     dt_s=2e-3, duration_s=2.0)  # fmt: skip
    run = sn.simulate(scene)
    shown = of_run(run)
    assert shown["t_s"][-1] == pytest.approx(2.0)
    assert np.array(shown["x_m"][-1]) == pytest.approx(run.x_m[-1], abs=1e-5)
    assert np.abs(shown["joint_deg"]).max() == pytest.approx(70, abs=0.5)
    v, theta = np.array([run.vx_m_s[-1], run.vy_m_s[-1]]), run.theta_rad[-1]
    sideways = v[1] * np.cos(theta) - v[0] * np.sin(theta)
    assert np.array(shown["slip_m_s"][-1]) == pytest.approx(sideways, abs=1e-5)


def test_slow_wheels_stick_on_dry_ground_alone() -> None:
    slow, robot = sn.Gait(1.2, 1.3, 0.8), sn.Robot(6, 0.0756, 0.076)
    for ground, sticks in ((GROUND, True), (sn.Ground(0.1, 10.0), False)):
        scene = sn.Scene(robot, ground, slow, start="steady", dt_s=5e-3, duration_s=4.0,
                         method="nonsmooth" if ground.dry else "rk4")  # fmt: skip
        assert bool(np.any(of_run(sn.simulate(scene))["stuck"])) == sticks


def test_set_points_of_the_virtual_robot_lie_on_the_model(page) -> None:
    shown = data(page)
    late = np.array(shown["t_s"]) > 3.0  # the ramp is over
    model, told = np.array(shown["joint_deg"])[late], np.array(shown["set_joint_deg"])[late]
    assert np.abs(model - told).max() < 1.0
    for axis in "xy":
        off = np.array(shown[f"set_{axis}_m"])[late] - np.array(shown[f"{axis}_m"])[late]
        assert np.abs(off).max() < 2e-3
    # the twin goes by the board's phase, which is slow at first: three cycles once it is settled
    t_s, centre = np.array(shown["t_s"]), np.mean([shown["x_m"], shown["y_m"]], axis=2)
    first = np.searchsorted(t_s, t_s[-1] - 3 * GAIT.period_s)
    travelled = np.hypot(*(centre[:, -1] - centre[:, first]))
    assert travelled == pytest.approx(0.1332 * (t_s[-1] - t_s[first]), rel=0.02)


def test_the_page_is_one_file(page) -> None:
    text = page.read_text()
    assert not re.search(r'(src|href)="', text)
    assert "http" not in text


def test_a_title_cannot_break_the_page(tmp_path) -> None:
    run = sn.simulate(
        sn.Scene(sn.Robot(3, 1.0, 0.1), GROUND, GAIT, method="nonsmooth", duration_s=0.1)
    )
    write_page(tmp_path / "p.html", "</script><b>", "a & b", of_run(run))
    assert "</script><b>" not in (tmp_path / "p.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["view", "absent.wire"], "'absent.wire' is no file"),
        (["view", __file__], "no recording"),
        (["view", "virtual", "--links", "4"], "of a robot of 6"),
        (["view", "virtual", "--out", "view.txt"], "must end in .html"),
    ],
)
def test_refusals(arguments, said, serpenoid, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    status, _, errors = serpenoid(*arguments)
    assert status in (1, 2)
    assert said in errors


@pytest.mark.parametrize("width", [390, 1100])
def test_a_browser_draws_it(page, tmp_path, width) -> None:
    seen = []
    with Browser(width, 844) as browser:
        for t_s in (1, 5):
            browser.opens(f"{page.as_uri()}?t={t_s}")
            assert browser.runs("return document.body.dataset.drawn") == "yes"
            assert browser.text("#clock") == f"{t_s}.00 s"
            browser.picture(tmp_path / f"{t_s}.png")
            seen.append(matplotlib.image.imread(tmp_path / f"{t_s}.png")[:, :, :3])
        assert browser.runs("return innerWidth") == width
        assert browser.runs("return document.documentElement.scrollWidth") <= width
    one, other = seen
    assert np.mean(np.any(one != other, axis=2)) > 1e-3  # the snake is elsewhere
    orange = np.all(np.abs(other - np.array([0xC1, 0x44, 0x0E]) / 255) < 0.05, axis=2)
    assert orange.sum() > 30  # the robot's set-points are drawn
