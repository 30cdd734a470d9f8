"""The page of the remade study: counts, readings, escapes, and data beside each figure."""

from __future__ import annotations

import pytest
from serpenoid.paper.claims import Claim, as_dict
from serpenoid.paper.study import Reading
from serpenoid.show.gaits.paper_page import turned_deg, write_page

CLAIMS = [
    Claim("Fig. 1", "a < b", "so it is", "agrees", "steady"),
    Claim("Fig. 2", "c", "no", "differs", "sweep"),
    Claim("Fig. 3", "d", "so it is", "agrees", "demo"),
]


def test_the_page_counts_escapes_and_links(tmp_path):
    (tmp_path / "b.csv").touch()
    reading = as_dict(CLAIMS, Reading("abs", "absolute", "x"))["reading"]
    write_page(tmp_path / "index.html", CLAIMS, [("a.png", "first"), ("b.png", "2nd")], reading)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "Of 3 claims 2 agree, 1 differ." in page
    assert "the mean of |P|, Eq. 57 drives the angles of the links, speed counts along glo" in page
    assert "a &lt; b" in page
    assert page.count("(<a href=") == 1
    assert 'href="b.csv"' in page
    assert 'name="viewport"' in page


def test_a_claim_leads_to_the_figure_that_shows_it(tmp_path):
    claims = [Claim(w, "a", "b", "agrees", "demo") for w in ("Fig. 7", "Fig. 17", "the search")]
    shown = [("fig6-7.png", "Figs. 6 and 7: errors"), ("fig17.png", "Fig. 17: speed")]
    reading = as_dict(claims, Reading("abs", "absolute", "x"))["reading"]
    write_page(tmp_path / "index.html", claims, shown, reading)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    for stem, words in (("fig6-7", "Fig. 7"), ("fig17", "Fig. 17")):
        assert f'<td><a href="#{stem}">{words}</a></td>' in page
        assert f'<figure id="{stem}"' in page
    assert "<td>the search</td>" in page
    assert '<a href="#fig6-7">Figs. 6 and 7</a>' in page  # the contents


def test_it_says_what_becomes_of_the_papers_bent_posture():
    """By the lab: 11 degrees in a second for a zigzag, as two other codes found; balanced, none."""
    assert abs(turned_deg([(-1) ** k for k in range(6)], 1.0)) == pytest.approx(11.4, abs=0.5)
    assert abs(turned_deg([1, -1, 0, 0, -1, 1], 1.0)) < 1e-6
