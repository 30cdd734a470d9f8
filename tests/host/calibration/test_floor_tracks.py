"""Tracks of pushes by the command: where the hand lets go, what is wrong, several in one file."""

import math

import numpy as np
import pytest
from calibration.floor_sessions import NEW, TRUTH, floor_setup
from command_line import serpenoid
from refusals import refused
from serpenoid import Ground, load_session
from serpenoid.lab.floor import Floor, Push
from serpenoid.lab.recording import Camera, film
from serpenoid.lab.robot import LabRobot


def filmed(seed, speed=0.9, **push):
    """Return a push in the lab, hand and all, as a film shows it; and when the hand let go."""
    rng = np.random.default_rng(seed)
    robot = LabRobot.whole_body(floor_setup().robot, Ground(*TRUTH)).drawn(rng, math.radians(0.5))
    track = Floor(robot).push([0.0] * 5, Push(speed, **push))
    return film(track, Camera(), rng)[:, :3], track.released_s


@pytest.fixture
def take(tmp_path):
    """Give a function that takes rows in; it returns status, what was said, and the folder."""
    folder = tmp_path / "s"
    serpenoid(f"{NEW} {folder}")

    def pushed(rows, name="track"):
        path = tmp_path / f"{name}.csv"
        path.write_text(
            "\n".join(["t_s,x_m,y_m", *(",".join(map(repr, r)) for r in rows.tolist())])
        )
        done = serpenoid(f"calibrate push {folder} {path} --unit m")
        said = " ".join((done.stdout + done.stderr).split())
        return done.returncode, said, folder

    return pushed


def test_the_part_that_counts_begins_soon_after_the_hand_let_go(take):
    for seed in range(8):
        rows, released_s = filmed(seed, 0.6 + 0.06 * seed)
        push = load_session(take(rows, seed)[2]).kept_pushes[-1]
        assert push.number == seed + 1  # it is not void
        assert 0.0 < push.start_s - released_s < 0.25
        assert 0.0006 < push.distance_sigma_m < 0.0016


ROWS = filmed(2)[0]
T = ROWS[:, 0]
WALL = np.where((T[:, None] > 1.2) & (np.arange(3) == 1), np.interp(1.2, T, ROWS[:, 1]), ROWS)


@pytest.mark.parametrize(
    ("rows", "doubt"),
    [
        (filmed(1, 0.3)[0], "it rolled 0.1"),
        (filmed(1, 0.95, rate_rad_s=2.5)[0], "it turned by +"),
        (ROWS[T < 1.4], "ends before the robot rests"),
        (WALL, "hit something"),
    ],
)
def test_a_push_that_is_none_is_void_and_says_why(take, rows, doubt):
    status, said, _ = take(rows)
    assert (status, doubt in said.partition("VOID: ")[2]) == (0, True), said


def test_what_is_no_push_at_all_is_refused(take):
    for scale, says in ((0.001, "no place moves"), (100.0, "10 m and 3 m/s; is its unit right?")):
        status, said, folder = take(ROWS * [1.0, scale, scale])
        assert (status, says in said) == (2, True), said
    assert not (folder / "tracks").exists()


def test_one_film_of_several_pushes_is_cut_by_itself(take):
    """The robot rests 1.5 s and is turned by hand between them."""
    rows, begins_s, at_m = [], 0.0, 0.0
    for k, sign in enumerate((1, -1, 1, -1)):
        one = filmed(10 + k)[0]
        places = [begins_s, at_m, 0.0] + (one - [one[0, 0], one[0, 1], 0.0]) * [1, sign, 1]
        at_m, begins_s = places[-1, 1], places[-1, 0] + 1.5
        still_s = np.arange(places[-1, 0] + 1 / 30, begins_s, 1 / 30)
        rows += [places, np.outer(np.ones_like(still_s), [0.0, at_m, 0.0])]
        rows[-1][:, 0] = still_s
    pushes = load_session(take(np.concatenate(rows))[2]).kept_pushes
    assert [push.way for push in pushes] == ["there", "back", "there", "back"]
    assert len({push.file_sha256 for push in pushes}) == 1
    assert len({push.track.sha256 for push in pushes}) == 4


def test_a_track_that_was_changed_or_lost_is_told(take):
    folder = take(ROWS)[2]
    path = folder / "tracks" / "0001.csv"
    path.write_text(path.read_text().replace("0.0", "0.1", 1))
    with refused("0001.csv: the track was changed since it was taken"):
        load_session(folder)
    path.unlink()
    with refused("0001.csv: the track is not there"):
        load_session(folder)
