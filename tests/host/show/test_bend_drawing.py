"""The drawing of a bent robot: links of one length, angles as labelled, the stored picture."""

import math
from itertools import pairwise
from pathlib import Path

import pytest
from serpenoid.show.session.bend_drawing import bend_shape, bend_svg

STORED = Path(__file__).parents[3] / "docs" / "_static" / "balanced_bend.svg"


@pytest.mark.parametrize(
    ("bend", "links"), [("balanced", 4), ("balanced", 6), ("balanced", 11), ("zigzag", 3)]
)
def test_what_is_labelled_is_what_is_drawn(bend, links):
    points, labels = bend_shape(bend, links, 20.0)
    lengths = [math.dist(a, b) for a, b in pairwise(points)]
    assert len(lengths) == links
    assert max(lengths) - min(lengths) < 0.3  # points are rounded to a tenth
    for (a, b, c), (_, _, text) in zip(
        zip(points, points[1:], points[2:], strict=False), labels, strict=True
    ):
        ahead, behind = (math.atan2(q[1] - p[1], q[0] - p[0]) for p, q in ((b, c), (a, b)))
        between = 180.0 - abs(math.degrees(ahead - behind))
        assert between == pytest.approx(float(text.rstrip("°")), abs=0.4)


def test_the_picture_in_the_documentation_is_this_drawing():
    drawn = bend_svg("balanced", 6, 15.0, "balanced bend of six links")
    assert STORED.read_text() == drawn + "\n"
