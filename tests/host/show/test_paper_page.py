"""The page of the remade study: counts, readings, escapes, links, and data beside each figure."""

from __future__ import annotations

import pytest
from serpenoid.paper.claims import Claim, as_dict
from serpenoid.paper.study import Reading
from serpenoid.show.gaits.paper_page import turned_deg, write_page

CLAIMS = [
    Claim("Fig. 7", "a < b", "so it is", "agrees", "steady"),
    Claim("Fig. 17", "c", "no", "differs", "sweep"),
    Claim("the search", "d", "so it is", "agrees", "demo"),
]
SHOWN = [("fig6-7.png", "Figs. 6 and 7: errors"), ("fig17.png", "Fig. 17: speed")]


def test_the_page_counts_escapes_and_links(tmp_path):
    (tmp_path / "fig17.csv").touch()
    reading = as_dict(CLAIMS, Reading("abs", "absolute", "x"))["reading"]
    write_page(tmp_path / "index.html", CLAIMS, SHOWN, reading)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "Of 3 claims 2 agree, 1 differ." in page
    assert "the mean of |P|, Eq. 57 drives the angles of the links, speed counts along glo" in page
    assert "a &lt; b" in page
    assert page.count("(<a href=") == 1
    assert 'href="fig17.csv"' in page
    assert 'name="viewport"' in page
    for stem, words in (("fig6-7", "Fig. 7"), ("fig17", "Fig. 17")):
        assert f'<td><a href="#{stem}">{words}</a></td>' in page
        assert f'<figure id="{stem}"' in page
    assert "<td>the search</td>" in page
    assert '<a href="#fig6-7">Figs. 6 and 7</a>' in page  # the contents


def test_it_says_what_becomes_of_the_papers_bent_posture():
    """By the lab: 11 degrees in a second for a zigzag, as two other codes found; balanced, none."""
    assert abs(turned_deg([(-1) ** k for k in range(6)], 1.0)) == pytest.approx(11.4, abs=0.5)
    assert abs(turned_deg([1, -1, 0, 0, -1, 1], 1.0)) < 1e-6
