"""Every page that the package writes: axe-core finds nothing, light and dark, on a phone too."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import serpenoid
from robots import NIRAKH_2005
from serpenoid.paper.claims import Claim, as_dict
from serpenoid.paper.study import Reading
from serpenoid.show.gaits.paper_page import write_page
from show.test_view_page import LIMPING
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
        written(folder, "view", str(LIMPING)),
        written(folder, "report", str(NIRAKH_2005)),
        study(folder),
    ]


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (390, True)])
def test_axe_finds_nothing(pages, width, dark) -> None:
    with Browser(width, 900, dark) as browser:
        for page in pages:
            browser.opens(page.as_uri())
            assert browser.barriers() == [], page.name
