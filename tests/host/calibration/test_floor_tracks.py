"""Tracks of pushes: where the hand lets go, what is wrong, several in one, files of programs."""

import math
import re

import numpy as np
import pytest
from calibration.floor_sessions import TRUTH, floor_setup
from refusals import refused
from serpenoid import Ground, load_session
from serpenoid.lab.floor import Floor, Push
from serpenoid.lab.recording import Camera, film
from serpenoid.lab.robot import LabRobot
from serpenoid.session.journal import Journal
from serpenoid.taking.new_session import create_session
from serpenoid.taking.pushes import keep_pushes
from serpenoid.taking.track_look import look_at, pushes_in

WHOLE = Ground(*TRUTH)
STRAIGHT = [0.0] * 5


def filmed(seed, speed=0.9, camera=None, **push):
    """A push in the lab, hand and all, as a film shows it; and when the hand let go."""
    rng = np.random.default_rng(seed)
    robot = LabRobot.whole_body(floor_setup().robot, WHOLE).drawn(rng, math.radians(0.5))
    track = Floor(robot).push(STRAIGHT, Push(speed, **push))
    return film(track, camera or Camera(), rng)[:, :3], track.released_s


def test_the_part_that_counts_begins_soon_after_the_hand_let_go():
    off = []
    for seed in range(8):
        rows, released = filmed(seed, 0.6 + 0.06 * seed)
        look = look_at(rows)
        off.append(look.cells["start_s"] - released)
        assert look.doubts == []
        assert 0.0006 < look.cells["distance_sigma_m"] < 0.0016
    assert min(off) > 0.0
    assert max(off) < 0.25


@pytest.mark.parametrize(
    ("speed", "push", "doubt"),
    [
        (0.3, {}, r"it rolled 0\.1\d m .* only: push harder"),
        (0.95, {"rate_rad_s": 2.5}, r"it turned by \+\d+ degrees"),
    ],
)
def test_a_push_that_is_none_is_told(speed, push, doubt):
    rows, _ = filmed(1, speed, **push)
    assert any(re.search(doubt, d) for d in look_at(rows).doubts)


def test_what_happens_to_a_push_is_seen():
    rows, _ = filmed(2)
    t = rows[:, 0]
    cut = rows[t < 1.4]
    assert any("ends before the robot rests" in d for d in look_at(cut).doubts)
    hit = rows.copy()
    hit[t > 1.2, 1] = np.interp(1.2, t, rows[:, 1])  # a wall
    assert any("hit something" in d for d in look_at(hit).doubts)
    still = rows.copy()
    still[:, 1:] = 0.001 * np.random.default_rng(0).normal(size=(len(t), 2))
    with refused("nothing moves"):
        look_at(still)
    with refused("times must rise"):
        look_at(rows[::-1])
    with refused("no finite number"):
        look_at(np.where(np.arange(len(t))[:, None] == 3, np.nan, rows))


def several(signs=(1, -1, 1, -1)):
    """One film of pushes there and back, the robot resting 1.5 s and turned by hand between."""
    rows, begins, at = [], 0.0, 0.0
    for k, sign in enumerate(signs):
        one, _ = filmed(10 + k, 0.9)
        t = one[:, 0] - one[0, 0]
        place = np.stack([begins + t, at + sign * (one[:, 1] - one[0, 1]), one[:, 2]], axis=1)
        rows.append(place)
        at, begins = place[-1, 1], place[-1, 0] + 1.5
        still = np.arange(place[-1, 0] + 1 / 30, begins, 1 / 30)
        rows.append(np.stack([still, np.full_like(still, at), np.zeros_like(still)], axis=1))
    return np.concatenate(rows)


def test_one_film_of_several_pushes_is_cut_by_itself(tmp_path):
    rows = several()
    pieces = pushes_in(rows)
    assert len(pieces) == 4
    folder = create_session(tmp_path / "s", floor_setup())
    with Journal(folder) as journal:
        kept = keep_pushes(journal, rows, {"lambda_deg": 0.0}, file_sha256="ab" * 32)
        assert [k.way for k in kept] == ["there", "back", "there", "back"]
    session = load_session(folder)
    assert [p.way for p in session.kept_pushes] == ["there", "back", "there", "back"]
    assert session.kept_pushes[0].track is not None
    assert session.kept_pushes[0].file_sha256 == "ab" * 8
    assert (folder / "tracks" / "0004.csv").exists()
    assert session.sha256 == load_session(folder).sha256


def test_what_is_too_fast_or_too_long_for_a_push_is_not_taken(tmp_path):
    rows, cells = filmed(2, 0.9)[0], {"lambda_deg": 0.0}
    with Journal(create_session(tmp_path / "s", floor_setup())) as journal:
        (push,) = keep_pushes(journal, rows * (1.0, 10.0, 10.0), cells)
        assert push.voided
        assert re.search("from 8.* is no push: at most 10 m and 3 m/s", push.comment)
        unsure = {"distance_m": 0.8, "duration_s": 3.0, "distance_sigma_m": 2.0}
        with refused("at most 0.05"):
            journal.add("push", cells | unsure)
        assert journal.add("push", cells | {"distance_m": 0.8, "duration_s": 3.0}) == 2
