"""The report of a session: self-contained, the same bytes again, voided readings shown as such."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
import serpenoid as sn
from calibration.synthetic_session import WHOLE_BODY_2005, changed, session, setup
from serpenoid.calibration.comparison import ComparedGait, Comparison
from serpenoid.show.session.report_page import session_page


@pytest.fixture(scope="module")
def made():
    named = replace(setup(15.0), name="lab <one> & two")
    taken = session(named, WHOLE_BODY_2005, np.random.default_rng(41))
    return changed(taken, 2, voided=True, comment="slipped & fell")


def compared() -> Comparison:
    gaits = tuple(
        ComparedGait(1.2, 1.3, f, 0.1 * f, 0.1 * f, 0.09 * f, 0.11 * f, 0.08 * f, 0.12 * f)
        for f in (0.5, 1.0)
    )
    ran = replace(gaits[0], runs=(9,), measured_m_s=0.06, sigma_m_s=0.001, residual_m_s=0.01)
    return Comparison(
        "x", 0.03, (ran,), gaits, (), 0.5, 0.5, 0.5, "agrees", "Agrees: as it should."
    )


def test_the_page_needs_nothing_else_and_is_the_same_again(made):
    fit = sn.fit_friction(made)
    page = session_page(made, fit, compared(), None)
    assert page == session_page(made, fit, compared(), None)
    fetched = re.findall(r'(?:src|href)="([^"]+)"|url[(]([^)]+)[)]|@import', page)
    assert all((a or b).startswith("#") for a, b in fetched)
    assert "<script" not in page
    HTMLParser().feed(page)
    ids = re.findall(r'id="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    for drawing in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        ElementTree.fromstring(drawing)


def test_the_page_says_what_it_must(made):
    page = session_page(made, sn.fit_friction(made), compared(), None)
    assert "lab &lt;one&gt; &amp; two" in page
    assert "ct_whole" in page
    assert "per link" in page
    assert "Agrees: as it should." in page
    row = re.search(r'<tr class="void">.*?</tr>', page)
    assert row
    assert "slipped &amp; fell" in row.group()
    assert "prefers-color-scheme:dark" in page
    assert made.sha256 in page


def test_another_reading_changes_the_page(made):
    other = changed(made, 4, belt_speed_m_s=made.readings[4].belt_speed_m_s + 0.01)
    pages = [session_page(m, sn.fit_friction(m), None, None) for m in (made, other)]
    assert pages[0] != pages[1]
