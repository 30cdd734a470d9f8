"""A kill at any byte while pushes are taken in: nothing is lost, no doubtful push counts."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from calibration.floor_sessions import floor_setup, push_track
from refusals import refused
from serpenoid.session.folder import read_session
from serpenoid.session.journal import Journal
from serpenoid.taking.films import take_track
from serpenoid.taking.new_session import create_session


def several_pushes(rng):
    """Return a file of pushes there and back; the first is so slow that it is void."""
    rows, at_s = [], 0.0
    for v0, turn in ((0.3, 0.0), (0.9, np.pi), (0.85, 0.0)):
        one = np.array(push_track(v0, (0.084, 1.2, 0.14, 0.27), rng, direction_rad=turn))
        one[:, 0] += at_s - one[0, 0]
        rows.append(one)
        at_s = one[-1, 0] + 1.5
    return np.concatenate(rows)


@pytest.fixture(scope="module")
def track(tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "pushes.csv"
    rows = several_pushes(np.random.default_rng(7))
    path.write_text("t,x,y\n" + "\n".join(",".join(map(repr, r)) for r in rows.tolist()) + "\n")
    return path


def take(folder, path):
    """Take the file in as a step says it."""
    with Journal(folder) as journal:
        way = "there" if not journal.session.kept_pushes else "back"  # the next one of the plan
        take_track(journal, path, "m", {"lambda_deg": 0.0, "way": way}, None, print)
    return [
        (p.way, p.voided, p.comment, p.track.sha256)
        for p in read_session(folder).readings_of("push")
    ]


def test_a_kill_at_any_byte_loses_nothing_and_counts_no_doubtful_push(tmp_path, track):
    folder = create_session(tmp_path / "s", floor_setup())
    readings = take(folder, track)
    assert [(way, void) for way, void, *_ in readings] == [
        ("back", True),
        ("there", False),
        ("back", False),
    ]
    text = (folder / "readings.csv").read_bytes()
    for cut in range(text.index(b"\n") + 1, len(text), 29):
        killed = shutil.copytree(folder, tmp_path / str(cut))
        (killed / "readings.csv").write_bytes(text[:cut])
        found = take(killed, track)
        assert [one for one in found if not one[1]] == [one for one in readings if not one[1]]
        assert all(one in found for one in readings)
    with refused("reading 2 is of this file already"):
        take(folder, track)
