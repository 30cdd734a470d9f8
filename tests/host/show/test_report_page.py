"""The report of a session: self-contained, the same bytes again, voided readings shown as such."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
import serpenoid as sn
from calibration.synthetic_session import WHOLE_BODY_2005, changed, session, setup
from serpenoid import Comparison
from serpenoid.prediction.comparison import ComparedGait
from serpenoid.session.gait_run import GaitRun
from serpenoid.session.push import Push
from serpenoid.session.session import Event
from serpenoid.session.station import BendCheck, ZeroReading
from serpenoid.show.session.report_page import session_page
from webdriver import Browser


@pytest.fixture(scope="module")
def made():
    named = replace(setup(15.0), name="lab <one> & two")
    taken = session(named, WHOLE_BODY_2005, np.random.default_rng(41))
    return changed(taken, 2, voided=True, comment="slipped & fell")


@pytest.fixture(scope="module")
def fit(made):
    return sn.fit_friction(made)


def compared() -> Comparison:
    gaits = tuple(
        ComparedGait(1.2, 1.3, f, 0.1 * f, 0.1 * f, 0.09 * f, 0.11 * f, 0.08 * f, 0.12 * f)
        for f in (0.5, 1.0)
    )
    ran = replace(gaits[0], runs=(9,), measured_m_s=0.06, sigma_m_s=0.001, residual_m_s=0.01)
    return Comparison(
        "x", 0.03, (ran, gaits[1]), (), 0.5, None, None, "agrees", "Agrees: as it should."
    )


@pytest.fixture(scope="module")
def page(made, fit):
    return session_page(made, fit, compared(), None)


def test_the_page_needs_nothing_else_and_is_the_same_again(made, fit, page):
    assert page == session_page(made, fit, compared(), None)
    fetched = re.findall(r'(?:src|href)="([^"]+)"|url[(]([^)]+)[)]|@import', page)
    assert all((a or b).startswith("data:image/svg+xml;base64,") for a, b in fetched)
    assert "<script" not in page
    HTMLParser().feed(page)
    ids = re.findall(r'id="([^"]+)"', page)
    assert len(ids) == len(set(ids))


def test_the_page_says_what_it_must(made, page):
    assert "lab &lt;one&gt; &amp; two" in page
    assert "ct_whole" in page
    assert "each of 6 links" in page
    assert "Agrees: as it should." in page
    row = re.search(r'<tr class="void">.*?</tr><tr class="said">.*?</tr>', page)
    assert row
    assert "slipped &amp; fell" in row.group()
    assert "prefers-color-scheme:dark" in page
    assert made.sha256 in page


def test_the_summary_and_the_counts_say_what_the_session_is(made, fit):
    assert "readings agree" in session_page(made, fit, None, None)
    assert "disagree by more than" in session_page(made, replace(fit, chi2=1e3), None, None)
    push = Push(90, 0.0, 1.0, 1.5, voided=True)
    page = session_page(made.with_reading(push), fit, None, None)
    assert "2 voided" in page
    for row in fit.rows():
        assert f"{row.value / made.setup.robot.links:.4g} {row.unit}" in page


def test_voided_readings_remarks_and_every_kind_of_reading_are_told(made, fit):
    run = GaitRun(40, 1.2, 1.3, 3.1, 0.1, 0.002, voided=True, comment="hit the wall")
    more = replace(
        made,
        readings=(*made.readings, run, ZeroReading(41, 0.002, -0.001), BendCheck(42, 0.26, 2.6)),
    )
    events = [Event("2026-01-02T03:04:06.678Z", "connect", 0, "uno, firmware 0.2.0, protocol 2")]
    page = session_page(replace(more, events=events), fit, None, None)
    assert '<tr class="void"><td>40</td>' in page
    assert '<td colspan="4">voided: hit the wall</td>' in page
    assert "voided: hit the wall" in page
    assert "zero +0.029°" in page
    assert "<td>149° between links: λ = 15.52°</td>" in page
    assert "Robot: uno, firmware 0.2.0, protocol 2." in page


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
def test_it_is_right_in_a_browser(made, fit, tmp_path, width, dark, paper):
    """On a screen, in the dark, on a phone, and on A4 (688 px between its margins)."""
    file = tmp_path / "report.html"
    long = replace(made.readings[2], comment="the hand was on the belt, it was taken once more")
    more = replace(
        made,
        readings=(
            *(*made.readings[:2], long, *made.readings[3:]),
            BendCheck(42, 0.26, 2.6, voided=True, comment="a remark of many words on this"),
        ),
    )
    page = session_page(more, fit, compared(), None)
    file.write_text(page, encoding="utf-8")
    with Browser(width, 900, dark, paper) as browser:
        browser.opens(file.as_uri())
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
