"""The report of a session: self-contained, the same bytes again, voided readings shown as such."""

from __future__ import annotations

import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import pytest
import serpenoid as sn
from command_line import serpenoid
from robots import NIRAKH_2005
from webdriver import Browser

REMARK = "the hand was on the belt & it was taken once more, as long words say"
ADDED = (
    "zero incline_deg=0.2 reversed_deg=0.1",
    "bend lambda_deg=15 between_links_deg=149",
    "gait alpha_deg=70 beta_deg=75 distance_m=2 duration_s=20 omega_rad_s=3.1",
    "gait alpha_deg=70 beta_deg=75 distance_m=0.5 duration_s=20 omega_rad_s=3.1",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """The session of 2005 with crawls that nobody made, two readings voided."""
    folder = tmp_path_factory.mktemp("report") / "session"
    shutil.copytree(NIRAKH_2005, folder)
    toml = folder / "session.toml"
    toml.write_text(toml.read_text().replace('name = "nirakh-2005"', 'name = "lab <one> & two"'))
    for words in ADDED:
        serpenoid(f"calibrate add {folder} {words}", check=True)
    serpenoid(f"calibrate void {folder} 2 --reason", REMARK, check=True)
    serpenoid(f"calibrate void {folder} 15 --reason 'hit the wall'", check=True)
    return folder


@pytest.fixture(scope="module")
def page(folder) -> Path:
    path = folder / "report.html"
    serpenoid(f"report {folder} --servo ideal --out {path}", check=True)
    return path


def test_the_page_needs_nothing_else_and_is_the_same_again(folder, page, tmp_path) -> None:
    again = tmp_path / "again.html"
    serpenoid(f"report {folder} --servo ideal --out {again}", check=True)
    text = page.read_text()
    assert text == again.read_text()
    fetched = re.findall(r'(?:src|href)="([^"]+)"|url[(]([^)]+)[)]|@import', text)
    assert len(fetched) == 2
    assert all((a or b).startswith("data:image/svg+xml;base64,") for a, b in fetched)
    assert "<script" not in text
    HTMLParser().feed(text)


def test_the_page_says_what_it_must(folder, page) -> None:
    text = page.read_text()
    session = sn.load_session(folder)
    fit = sn.fit_friction(session)
    for row in fit.rows():
        assert f"{row.value / fit.robot.links:.4g} {row.unit}" in text
    for words in (
        "lab &lt;one&gt; &amp; two",
        "ct_whole",
        "each of 6 links",
        "readings agree",
        "2 void readings",
        "Agrees: the speed of 1 gait is likely enough",
        REMARK.replace("&", "&amp;"),
        '<tr class="void"><td>15</td>',
        '<td colspan="4">voided: hit the wall</td>',
        "zero +0.150°",
        "149° between links: λ = 15.5°",
        "prefers-color-scheme:dark",
        session.sha256,
    ):
        assert words in text, words


SHOWN = """
const wide = [...document.querySelectorAll('.wide, figure')];
const lines = e => {
  const all = document.createRange();
  all.selectNodeContents(e);
  return all.getClientRects().length;
};
const words = [...document.querySelectorAll('th')].filter(e => !/\\s/.test(e.textContent.trim()));
return {broken: words.filter(e => lines(e) > 1).length, words: words.length,
  page: document.documentElement.scrollWidth, window: innerWidth,
  clipped: wide.filter(e => e.scrollWidth > e.clientWidth + 1).length, parts: wide.length,
  cut: wide.filter(e => e.className && e.scrollWidth > e.clientWidth).length,
  back: getComputedStyle(document.body).backgroundColor,
  drawing: getComputedStyle(document.querySelector('figure img')).filter,
  struck: getComputedStyle(document.querySelector('.void td')).textDecorationLine}
"""


@pytest.mark.parametrize(
    ("width", "dark", "paper"),
    [(1100, False, False), (390, True, False), (688, False, True)],
)
def test_it_is_right_in_a_browser(page, width, dark, paper) -> None:
    """On a screen, in the dark, on a phone, and on A4 (688 px between its margins)."""
    with Browser(width, 900, dark, paper) as browser:
        browser.opens(page.as_uri())
        seen = browser.runs(SHOWN)
    assert seen["window"] == width
    assert seen["page"] <= width  # what is wider scrolls in its own box ...
    assert seen["parts"] >= 5
    assert seen["broken"] == 0  # a word of a heading stands in one line
    assert seen["words"] > 5
    assert seen["cut"] == 0  # no table, on a phone neither
    assert width == 390 or seen["clipped"] == 0  # ... and on paper nothing is out of sight
    assert (seen["back"] == "rgb(23, 25, 28)") is dark
    assert ("invert" in seen["drawing"]) is dark
    assert seen["struck"] == "line-through"
