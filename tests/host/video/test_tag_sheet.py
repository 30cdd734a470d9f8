"""The sheet of tags: true size, all tags found when its picture is looked at."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from refusals import refused
from serpenoid.show.video.tag_sheet import PAPERS_MM, tag_sheet
from serpenoid.video.seeing.detect import TagFinder
from serpenoid.video.seeing.tags import tag_cells, tag_side_m

DOTS_PER_MM = 300 / 25.4


@pytest.mark.parametrize(("links", "paper"), [(2, "a4"), (6, "letter")])
def test_printed_tags_are_found_with_their_numbers_and_size(tmp_path, links, paper) -> None:
    side = tag_side_m(0.076)
    tag_sheet(tag_cells(links), side, 0.076, paper, tmp_path / "tags.png")
    page = cv2.imread(str(tmp_path / "tags.png"), cv2.IMREAD_GRAYSCALE)
    wide, high = PAPERS_MM[paper]
    assert page.shape == pytest.approx((high * DOTS_PER_MM, wide * DOTS_PER_MM), abs=2)
    tags, _ = TagFinder(links).find(page)
    assert np.isfinite(tags).all()
    for corners in tags:
        width = np.linalg.norm(corners[1] - corners[0]) / DOTS_PER_MM
        assert width == pytest.approx(1e3 * side, abs=0.15)
        assert corners[1, 0] > corners[0, 0]  # the arrow's way is the tag's own right


def test_tags_that_do_not_fit_are_refused(tmp_path) -> None:
    with refused("13 tags of 34 mm do not fit on a4; give a smaller --tag-mm"):
        tag_sheet(tag_cells(13), 0.034, 0.076, "a4", tmp_path / "tags.pdf")
    tag_sheet(tag_cells(13), 0.028, 0.076, "a4", tmp_path / "tags.pdf")
    with refused("links is 14"):
        tag_cells(14)
