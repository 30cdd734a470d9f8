"""A kill at any write while pushes are taken in: nothing is lost, no doubtful push counts.

Each write and each sync of the disk is cut short once: half of a line is then there, or all of it.
"""

from __future__ import annotations

import io
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from calibration.floor_sessions import floor_setup, push_track
from serpenoid.session.folder import read_session
from serpenoid.session.journal import Journal
from serpenoid.taking.films import take_track
from serpenoid.taking.new_session import create_session


class Killed(BaseException):
    """Stands for a kill: no handler of errors sees it."""


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


def take(folder, path, kill_at=None):
    """Take the file in as a step says it, killed at the n-th write or sync; return the count."""
    count, opened, sync = 0, Path.open, os.fsync

    def counted(kills):
        nonlocal count
        count += 1
        if count == kill_at:
            kills()
            raise Killed

    class Cut(io.FileIO):
        def write(self, data):
            counted(lambda: super(Cut, self).write(data[: len(data) // 2]))
            return super().write(data)

    def synced(fd):
        counted(lambda: None)
        sync(fd)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(
            Path, "open", lambda p, *a, **k: Cut(p, "r+") if a == ("r+b",) else opened(p, *a, **k)
        )
        patched.setattr(os, "fsync", synced)
        with Journal(folder) as journal:
            way = "there" if not journal.session.kept_pushes else "back"  # as the plan goes on
            take_track(journal, path, "m", {"lambda_deg": 0.0, "way": way})
    return count


def told(folder):
    return [
        (p.way, p.voided, p.comment, p.track.sha256)
        for p in read_session(folder).readings_of("push")
    ]


def test_a_kill_at_any_write_loses_nothing_and_counts_no_doubtful_push(tmp_path, track):
    folder = create_session(tmp_path / "s", floor_setup())
    shutil.copytree(folder, tmp_path / "empty")
    writes = take(folder, track)
    whole = told(folder)
    assert [(way, void) for way, void, *_ in whole] == [
        ("back", True),
        ("there", False),
        ("back", False),
    ]
    assert writes == 9  # of each: its track, its line's half, its line
    for kill_at in range(1, writes + 1):
        cut = tmp_path / f"cut{kill_at}"
        shutil.copytree(tmp_path / "empty", cut)
        with pytest.raises(Killed):
            take(cut, track, kill_at=kill_at)
        assert told(cut) == whole[: len(told(cut))]
        if kill_at < writes:
            take(cut, track)
        left = told(cut)
        assert [one for one in left if not one[1]] == [one for one in whole if not one[1]]
        assert all(one in left for one in whole)
