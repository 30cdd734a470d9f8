"""Every page that the package writes: axe-core finds nothing, light and dark, on a phone too."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import serpenoid
from robots import NIRAKH_2005
from show.test_view_page import LIMPING
from webdriver import Browser


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
    ]


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (390, True)])
def test_axe_finds_nothing(pages, width, dark) -> None:
    with Browser(width, 900, dark) as browser:
        for page in pages:
            browser.opens(page.as_uri())
            assert browser.barriers() == [], page.name
