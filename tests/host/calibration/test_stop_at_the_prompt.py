"""Keys at the prompts of a session: they steer, they stop, and Ctrl-C leaves with nothing lost."""

from __future__ import annotations

import time

import pytest
from calibration.conversations import begun
from robot.fake_board import FakeBoard
from robot.patience import LONG_S
from robot.terminal import Person

BELT = "without zero before"
GAIT = f"{BELT}; plan.gait_runs = 1; " + "; ".join(
    f"without {key}" for key in ("straight", "bend 7.5", "bend 15", "bend 30")
)
STEER = "Enter keeps the steering: "
POSE, INCLINE = "Enter straightens the robot (hands off): ", "the inclinometer shows (deg)"
SPEED = "belt speed (m/s): "


@pytest.fixture
def seat(tmp_path, request):
    """Give a person before `calibrate`, the board, and the session's folder."""
    folder = tmp_path / "session"
    begun(folder, request.param)
    with (
        FakeBoard(pace=time.monotonic) as fake,
        Person(f"calibrate take {folder} --port {fake.port}") as person,
    ):
        yield person, fake, folder


def moved(person: Person, fake: FakeBoard, state: str, asks: str, then: str) -> None:
    """Have the robot set in motion, and wait for the prompt that follows."""
    person.answers(asks, "\r")
    if asks == POSE:
        person.answers(STEER, "\r")
    assert fake.await_state(state)
    person.sees(then)


@pytest.mark.parametrize("seat", [BELT], indirect=True)
@pytest.mark.parametrize("key", ["\x1b", " "])
def test_a_key_stops_a_robot_that_is_held(seat, key):
    person, fake, _ = seat
    moved(person, fake, "pose", POSE, INCLINE)
    person.presses("\x1b[D")
    person.sees("[+0.25 deg on every joint]")
    person.presses(key)
    person.sees("stopped by a key: pulses off")
    person.sees(POSE)
    assert fake.state == "idle"
    assert fake.received.count(b"\n!\n") == 1
    person.presses("\r")
    assert fake.await_state("pose")


@pytest.mark.parametrize("seat", [GAIT], indirect=True)
def test_a_key_stops_a_robot_that_crawls(seat):
    person, fake, _ = seat
    moved(person, fake, "gait", "Enter starts the robot: ", "its film")
    person.presses("\x1b")
    person.sees("stopped by a key: pulses off")
    assert fake.await_state("idle")


@pytest.mark.parametrize("seat", [BELT], indirect=True)
def test_a_space_within_a_line_is_a_space(seat):
    person, fake, _ = seat
    moved(person, fake, "pose", POSE, INCLINE)
    person.presses("2.0 0.2\r")
    person.sees("drift left over")
    assert fake.state in ("pose", "hold")
    assert b"\n!\n" not in fake.received


@pytest.mark.parametrize("seat", [BELT], indirect=True)
@pytest.mark.parametrize("prompt", range(7))
def test_ctrl_c_at_any_prompt_stops_and_leaves_and_loses_nothing(seat, prompt):
    person, fake, folder = seat
    answers = [(POSE, "\r"), (STEER, "\r"), (INCLINE, "2.0\r"), (SPEED, "0.05\r")]
    answers += [("drift left over", "\r"), ("expected 0.12 to", "keep\r"), (INCLINE, "\r")]
    for asked, typed in answers[:prompt]:
        person.answers(asked, typed)
    person.sees(answers[prompt][0])
    assert fake.state == ("idle" if prompt == 0 else "pose")
    person.presses("\x03")
    assert person.leaves(LONG_S) == 130
    assert fake.state == "idle"
    assert b"\n!\n" in fake.received
    assert "Left. Everything read so far is kept" in person.screen
    assert len((folder / "readings.csv").read_text().splitlines()) == 1 + (prompt == 6)
