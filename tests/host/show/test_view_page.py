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
from command_line import serpenoid
from robots import BINGHAM, NIRAKH_2005, OF_2005, gait_in_deg
from webdriver import Browser

LIMPING = NIRAKH_2005.parents[1] / "host/examples/limping_on_a_slope.toml"
GAIT = gait_in_deg(70, 75, 5.0)


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("view")
    record, path = folder / "run.wire", folder / "virtual.html"
    drive = "drive --port virtual:fast --alpha-deg 70 --beta-deg 75 --omega-rad-s 5 --duration-s 8"
    serpenoid(f"{drive} --record {record}", check=True)
    serpenoid(f"view {record} --out {path}", check=True)
    return path


def data(page: Path) -> dict:
    text = page.read_text()
    return json.loads(re.search(r'type="application/json">(.*?)</script>', text, re.S)[1])


def test_a_run_is_shown_as_it_is(tmp_path) -> None:
    path = tmp_path / "<b>scene.toml"
    scene = sn.Scene(OF_2005, BINGHAM, GAIT, start="steady", dt_s=2e-3, duration_s=2.0)
    sn.save_scene(scene, path)
    serpenoid("view", path, "--out", tmp_path / "page.html", check=True)
    shown, run = data(tmp_path / "page.html"), sn.simulate(scene)
    assert shown["t_s"][-1] == pytest.approx(2.0)
    assert np.array(shown["x_m"][-1]) == pytest.approx(run.x_m[-1], abs=1e-5)
    assert np.abs(shown["joint_deg"]).max() == pytest.approx(70, abs=0.5)
    slip = run.vy_m_s * np.cos(run.theta_rad) - run.vx_m_s * np.sin(run.theta_rad)
    assert np.array(shown["slip_m_s"][-1]) == pytest.approx(slip[-1], abs=1e-5)
    text = (tmp_path / "page.html").read_text()
    assert not re.search(r'<b>|http|(src|href)="', text)


def test_the_model_of_the_virtual_robot_ramps_with_it_and_then_keeps_its_speed(page) -> None:
    shown = data(page)
    t_s, joints = np.array(shown["t_s"]), np.abs(np.array(shown["joint_deg"])).max(axis=1)
    assert joints[0] < 1.0
    assert joints[t_s < 1.0].max() < 35.0  # half the amplitude: the firmware ramps
    late = t_s > 3.0
    assert joints[late].max() == pytest.approx(70.0, abs=0.05)
    # three periods up to the end: as fast as the periodic state, found by other code
    centre = np.mean([shown["x_m"], shown["y_m"]], axis=2)
    began = [np.interp(t_s[-1] - 3 * GAIT.period_s, t_s, c) for c in centre]
    travelled = math.hypot(*(centre[:, -1] - began))
    wanted = sn.steady_gait(OF_2005, BINGHAM, GAIT).speed_m_s
    assert travelled == pytest.approx(3 * GAIT.period_s * wanted, rel=4e-3)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("view absent.wire", "'absent.wire' does not exist"),
        (f"view {__file__}", "no recording"),
        (f"view {LIMPING} --out view.txt", "must end in .html"),
    ],
)
def test_refusals(line, said, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = serpenoid(line)
    assert done.returncode in (1, 2)
    assert said in done.stderr


@pytest.mark.parametrize(("width", "dark"), [(390, False), (1280, True)])
def test_a_browser_draws_it(page, tmp_path, width, dark) -> None:
    seen = []
    with Browser(width, 844, dark) as browser:
        browser.opens(page.as_uri())
        assert browser.runs("return document.body.dataset.drawn") == "yes"
        for t_s in (1, 5):
            browser.runs(f"at('when').value = {t_s}; at('when').oninput()")
            assert browser.text("#clock") == f"{t_s}.00 s"
            browser.picture(tmp_path / f"{t_s}.png")
            seen.append(matplotlib.image.imread(tmp_path / f"{t_s}.png")[:, :, :3])
        assert browser.runs("return document.documentElement.scrollWidth") <= width
    one, other = seen
    assert np.mean(np.any(one != other, axis=2)) > 1e-3  # the snake is elsewhere
    assert bool(np.median(one) < 0.15) == dark
