"""A kind of reading is declared once: what is declared here goes through files, tables and hash."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from serpenoid import BadInput
from serpenoid.calibration.kinds.declaration import PLANNED, Field, Kind, Word, check_fields
from serpenoid.calibration.kinds.instruments import Stopwatch
from serpenoid.calibration.kinds.table import KINDS
from serpenoid.calibration.kinds.tracks import Track
from serpenoid.calibration.session_file import read_session
from serpenoid.calibration.taking.journal import Journal
from serpenoid.calibration.taking.memory import MemoryRecord
from serpenoid.calibration.taking.new_session import create_session, default_setup
from serpenoid.calibration.taking.parse_number import read_cells
from serpenoid.show.session.table import rows

FIELDS = (
    Field("lambda_deg", "the bend", "angle", 0.0, 60.0, source=PLANNED),
    Field("slope_deg", "the floor's slope", "incline", -5.0, 5.0, optional=True),
    Word("way", ("there", "back")),
)


@dataclass(frozen=True)
class Push:
    number: int
    lambda_rad: float
    track: Track
    way: str = "there"
    slope_rad: float | None = None
    voided: bool = False
    comment: str = ""
    time_utc: str = ""

    def __post_init__(self):
        check_fields(self, FIELDS)


COAST = Kind(
    "coast",
    Push,
    FIELDS,
    lambda p: ("push", f"{len(p.track.values)} samples"),
    fitted=True,
    track=("t_s", "x_m"),
)
SAMPLES = [[0.0, 0.0], [0.1, 0.05], [0.2, 0.0911]]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setitem(KINDS, "coast", COAST)
    return create_session(tmp_path / "session", default_setup("made up"))


def test_a_new_kind_is_kept_redone_shown_and_hashed(folder):
    with Journal(folder) as journal:
        before = journal.session.sha256
        cells = read_cells("coast", ["lambda_deg=20", "slope_deg=1%"], journal.session.setup)
        assert journal.add("coast", cells | {"way": "back"}, samples=SAMPLES) == 1
        assert journal.session.sha256 != before
        (push,) = journal.session.of("coast")
        assert (push.way, push.number) == ("back", 1)
        assert push.slope_rad == pytest.approx(math.atan(0.01))
        assert push.track.values == pytest.approx(np.array(SAMPLES))
        assert rows(journal.session) == [["1", "push", "3 samples", "", ""]]
        journal.event("void", 1, "hit a chair")
        assert journal.session.of("coast")[0].voided
        assert journal.session.sha256 == before
    assert (folder / "tracks" / "0001.csv").read_text().startswith("t_s,x_m\n0,0\n")
    header = (folder / "readings.csv").read_text().splitlines()[0]
    assert "slope_deg" not in header  # old programs still read the file


def test_a_track_that_was_changed_or_lost_is_told(folder):
    with Journal(folder) as journal:
        journal.add("coast", {"lambda_deg": 0.0}, samples=SAMPLES)
    path = folder / "tracks" / "0001.csv"
    text = path.read_text()
    path.write_text(text.replace("0.05", "0.06"))
    with pytest.raises(BadInput, match=r"0001.csv: the track was changed since it was taken"):
        read_session(folder)
    path.unlink()
    with pytest.raises(BadInput, match=r"0001.csv: the track is not there"):
        read_session(folder)
    path.write_text(text)
    rows_there = (folder / "readings.csv").read_text()
    (folder / "readings.csv").write_text(rows_there.replace("tracks/", "../"))
    with pytest.raises(BadInput, match=r"track is '\.\./0001\.csv'"):
        read_session(folder)


@pytest.mark.parametrize("bad", [[[0.0, 1.0]], [[0.0], [1.0]], [[0.0, math.nan], [1.0, 2.0]]])
def test_what_is_no_track_is_not_kept(folder, bad):
    with Journal(folder) as journal, pytest.raises(BadInput, match="a track"):
        journal.add("coast", {"lambda_deg": 0.0}, samples=bad)
    assert not (folder / "tracks").exists()
    assert read_session(folder).further == ()


def test_a_session_in_memory_holds_it_too(folder):
    record = MemoryRecord(default_setup("made up"))
    record.add("coast", {"lambda_deg": 0.0}, samples=SAMPLES)
    record.add("coast", {"lambda_deg": 0.0}, samples=SAMPLES, replaces=1)
    assert [p.voided for p in record.session.of("coast")] == [True, False]


def test_limits_hold_for_files_and_for_objects(folder):
    track = Track.of(("t_s", "x_m"), SAMPLES)
    with pytest.raises(BadInput, match=r"lambda_rad is 1\.2; it must be a finite number"):
        Push(1, 1.2, track)
    with pytest.raises(BadInput, match="way is 'up'; it must be one of there, back"):
        Push(1, 0.2, track, way="up")
    with Journal(folder) as journal, pytest.raises(BadInput, match="lambda_deg is 61"):
        journal.add("coast", {"lambda_deg": 61.0}, samples=SAMPLES)


def test_every_kind_is_declared_whole():
    """Each field is an attribute of the reading, and every kind can be told in words."""
    for kind in KINDS.values():
        there = set(kind.reading.__dataclass_fields__)
        assert {f.name for f in kind.fields} | {"number", "voided", "comment", "time_utc"} <= there


def test_a_belt_check_tells_the_scale(folder):
    with Journal(folder) as journal:
        cells = read_cells(
            "belt",
            ["belt_speed_m_s=1.8km/h", "distance_m=27.5", "duration_s=50"],
            journal.session.setup,
        )
        journal.add("belt", cells)
        (check,) = journal.session.of("belt")
        assert check.scale == pytest.approx(1.1)
        watch = Stopwatch(0.01, 0.2)
        by_hand = 1.1 * math.hypot(0.01 / 27.5, 0.2 / 50)
        assert check.scale_sigma(watch) == pytest.approx(by_hand)
        with pytest.raises(BadInput, match=r"3.6 times as fast as it showed.*check the units"):
            journal.add("belt", cells | {"distance_m": 90.0})
        assert replace(check, voided=True, distance_m=90.0).scale == pytest.approx(3.6)
