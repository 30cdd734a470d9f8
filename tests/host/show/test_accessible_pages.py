"""The pages of `view` and `report`: axe-core finds no barrier, light and dark, also on a phone."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import serpenoid
from robots import NIRAKH_2005
from show.test_view_page import LIMPING
from webdriver import Browser


def page(folder: Path, command: str, source: Path) -> Path:
    path = folder / f"{command}.html"
    serpenoid(command, source, "--out", path, check=True)
    return path


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> list[Path]:
    folder = tmp_path_factory.mktemp("pages")
    return [page(folder, "view", LIMPING), page(folder, "report", NIRAKH_2005)]


@pytest.mark.parametrize(("width", "dark"), [(1280, False), (390, True)])
def test_axe_finds_no_barrier(pages, width, dark) -> None:
    with Browser(width, 900, dark) as browser:
        for path in pages:
            browser.opens(path.as_uri())
            assert browser.barriers() == [], path.name
