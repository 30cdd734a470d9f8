"""Every page that the package writes: axe-core finds nothing, light and dark, on a phone too."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import pytest
import serpenoid as sn
from command_line import serpenoid
from robots import NIRAKH_2005
from serpenoid.calibration.taking.new_session import default_setup
from serpenoid.calibration.taking.procedure import next_step
from serpenoid.calibration.taking.simulated import SimulatedPerson, Truth
from serpenoid.calibration.taking.treadmill import Posture, take_step
from serpenoid.paper.claims import Claim, as_dict
from serpenoid.paper.study import Reading
from serpenoid.show.gaits.paper_page import write_page
from serpenoid.show.pages.server import Page
from serpenoid.show.session.state import state_of
from simulated_sessions import MemoryRecord
from webdriver import Browser


def study(folder: Path) -> Path:
    claims = [
        Claim("Fig. 6", "a", "b", "differs", "demo"),
        Claim("text", "a", "b", "agrees", "fit"),
    ]
    reading = as_dict(claims, Reading("abs", "absolute", "x"))["reading"]
    write_page(folder / "study.html", claims, [("fig6-7.png", "Figs. 6 and 7: errors")], reading)
    return folder / "study.html"


def written(folder: Path, *arguments: str) -> Path:
    path = folder / f"{arguments[0]}.html"
    serpenoid(*arguments, "--out", path, check=True)
    return path


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> list[Path]:
    folder = tmp_path_factory.mktemp("pages")
    return [
        written(folder, "view", "virtual"),
        written(folder, "report", str(NIRAKH_2005)),
        study(folder),
    ]


def state() -> dict:
    """Return what the page beside a treadmill shows after some readings."""
    setup = default_setup("made up")
    record = MemoryRecord(setup)
    treadmill = SimulatedPerson(setup, Truth(sn.Ground(0.084, 1.2, 0.14, 0.27)), seed=2)
    posture = Posture()
    for _ in range(30):
        take_step(record, treadmill, posture)
    step = next_step(record.session, posed_deg=posture.bend_deg)
    return state_of(record.session, step, "holds")


@pytest.mark.parametrize("name", ["beside.html"])
def test_axe_finds_nothing_beside_a_treadmill(name) -> None:
    text = files("serpenoid.show.session").joinpath(name).read_text(encoding="utf-8")
    with Page(text, lambda: None) as page, Browser(390, 844, dark=True) as browser:
        if name == "beside.html":
            page.publish(state())
        browser.opens(page.url)
        if name == "beside.html":
            browser.sees("#link", "live")
        assert browser.barriers() == []


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (390, True)])
def test_axe_finds_nothing(pages, width, dark) -> None:
    with Browser(width, 900, dark) as browser:
        for page in pages:
            browser.opens(page.as_uri())
            assert browser.barriers() == [], page.name
