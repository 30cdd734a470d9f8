"""A kind of reading is declared once: what is declared here goes through files, tables and hash."""

import math

import numpy as np
import pytest
from refusals import refused
from serpenoid.session.folder import read_session
from serpenoid.session.journal import Journal
from serpenoid.session.rows import kind_of
from serpenoid.show.session.table import rows
from serpenoid.taking.parse_number import first_number, read_cells

SAMPLES = [[0.0, 0.0, 0.0], [0.1, 0.05, 0.0], [0.2, 0.0911, 0.001]]
FILMED = {"lambda_deg": 0.0, "by": "film"}


def test_a_reading_is_kept_shown_voided_and_hashed(folder):
    with Journal(folder) as journal:
        before = journal.session.sha256
        cells = read_cells("push", ["lambda_deg=20", "turned_deg=2,5"], journal.session.setup)
        assert journal.add("push", cells | {"by": "film", "way": "back"}, samples=SAMPLES) == 1
        assert journal.session.sha256 != before
        (push,) = journal.session.of("push")
        assert (push.way, push.number) == ("back", 1)
        assert push.turned_rad == pytest.approx(math.radians(2.5))
        assert push.track.values == pytest.approx(np.array(SAMPLES))
        ((number, what, values, *_),) = rows(journal.session)
        assert (number, what) == ("1", "push back, bend 20°")
        assert "3 places" in values
        journal.event("void", 1, "hit a chair")
        assert journal.session.of("push")[0].voided
        assert journal.session.sha256 == before
    assert (folder / "tracks" / "0001.csv").read_text().startswith("t_s,x_m,y_m\n0,0,0\n")
    header = (folder / "readings.csv").read_text().splitlines()[0]
    assert "turned_deg" not in header  # old programs still read the file


def test_a_track_that_was_changed_or_lost_is_told(folder):
    with Journal(folder) as journal:
        journal.add("push", FILMED, samples=SAMPLES)
    path = folder / "tracks" / "0001.csv"
    text = path.read_text()
    path.write_text(text.replace("0.05", "0.06"))
    with refused(r"0001.csv: the track was changed since it was taken"):
        read_session(folder)
    path.unlink()
    with refused(r"0001.csv: the track is not there"):
        read_session(folder)


@pytest.mark.parametrize(
    "bad", [[[0.0] * 3], [[0.0], [1.0]], [[0.0, math.nan, 0.0], [1.0, 2.0, 0.0]]]
)
def test_what_is_no_track_is_not_kept(folder, bad):
    with Journal(folder) as journal, refused("a track"):
        journal.add("push", FILMED, samples=bad)
    assert not (folder / "tracks").exists()
    assert read_session(folder).readings == ()


@pytest.mark.parametrize(
    ("text", "unit", "value", "rest"),
    [
        ("1.8", "km/h", 0.5, ""),
        ("1.8 mph 3", "km/h", 0.804672, "3"),
        ("0,5 -1 deg", "m/s", 0.5, "-1 deg"),
        ("0.5;.2", "", 0.5, ".2"),
    ],
)
def test_a_number_without_unit_is_in_the_one_that_the_belt_shows(text, unit, value, rest):
    field = kind_of("station").numbers()["belt_speed_m_s"]
    assert first_number(text, field, unit) == (pytest.approx(value), rest)
