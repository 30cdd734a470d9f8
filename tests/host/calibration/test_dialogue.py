"""A made-up person in the dialogue, word for word; a full disk, a silence and a lost robot."""

import math
from dataclasses import replace

import numpy as np
import pytest
from calibration.conversations import FILES, Typist, played
from calibration.floor_sessions import TRUTH, push_track
from command_line import serpenoid
from robot.fake_board import eeprom_after
from serpenoid import load_session
from serpenoid.base.errors import RecordingFailed, RobotLost
from serpenoid.commands.friction.calibrate_person import film_reader
from serpenoid.robot.wire.virtual import VirtualLink
from serpenoid.session.folder import read_events
from serpenoid.session.journal import Journal
from serpenoid.taking.dialogue import Dialogue
from serpenoid.taking.new_session import create_session, default_setup, on_place
from serpenoid.taking.session_robot import SessionRobot


def talk(folder, *lines, robot=None, film=None, **given):
    """Return what a person heard, and the session afterwards."""
    person = Typist(*lines, robot=robot)
    with Journal(folder) as journal:
        Dialogue(journal, person, film or film_reader(None), robot, **given).run()
        return person.heard, journal.session


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_it_is_said_as_it_is_written_down(file):
    """People at the prompt, word for word: what they type, and all that is said to them."""
    assert played(file) == file.read_text()


ZERO = "0,1 -0.1"
STATION = "2.0 0.2", ""  # incline and belt speed, then no drift


@pytest.mark.parametrize("seed", [1, 8, 12])
def test_a_floor_with_films_takes_twenty_answers(tmp_path, seed):
    """One film holds all pushes of a pose; what each of its crawls shows is in one, too."""
    setup = default_setup("made up")
    folder = create_session(tmp_path / "s", replace(setup, plan=on_place(setup.plan, "floor")))
    rng = np.random.default_rng(seed)
    lines = []
    for pose, bend_deg in enumerate((0, 20, 42)):
        film = tmp_path / f"{pose}.csv"
        rows, at_s = [], 0.0
        for k in range(8):
            turn = math.pi * (k % 2)
            bend = {"direction_rad": turn, "bend_rad": math.radians(bend_deg)}
            one = np.array(push_track(0.9, TRUTH, rng, **bend))
            one[:, 0] += at_s - one[0, 0]
            rows, at_s = [*rows, *one.tolist()], one[-1, 0] + 1.5
        film.write_text("\n".join(["t_s,x_m,y_m", *(",".join(map(repr, r)) for r in rows)]))
        lines += ["", *([f"{180 - 2 * bend_deg}"] if bend_deg else []), str(film)]
    lines += 4 * ["", "10 1"]
    with SessionRobot("virtual:fast") as seat:
        heard, session = talk(folder, *lines, robot=seat)
    assert "Nothing of the plan is left to take; `serpenoid fit" in heard
    assert len(lines) <= 20
    assert len(session.kept_pushes) == 24
    assert len(session.kept_crawls) == 4


def lines_of(reading):
    """Return what is typed for a reading where the robot bends and crawls by itself."""
    cells = vars(reading)
    degrees = {
        name: f"{math.degrees(cells[name]):.6g}"
        for name in cells
        if name.endswith("_rad") and cells[name] is not None
    }
    if reading.kind == "zero":
        return [degrees["incline_rad"], degrees["reversed_rad"]]
    if reading.kind == "bend":
        return ["", degrees["between_links_rad"]]
    if reading.kind == "station":
        return [
            degrees["incline_rad"],
            f"{reading.belt_speed_m_s:.5g} m/s",
            f"{reading.drift_m_s:g}",
        ]
    if reading.kind == "belt":
        return [f"{reading.belt_speed_m_s} m/s", f"{reading.distance_m}", f"{reading.duration_s}"]
    return ["", f"{reading.duration_s}"]


def test_a_treadmill_takes_at_most_ninety_answers(folder, tmp_path):
    """What a simulated person read is typed again by one with a robot, a number a line."""
    script = tmp_path / "person.toml"
    script.write_text("[simulated]\nseed = 3\nct = 0.084\ncn = 1.2\nft0 = 0.14\nfn0 = 0.27\n")
    other = create_session(tmp_path / "other", default_setup("other"))
    serpenoid(f"calibrate {other} --script {script}")
    session = load_session(other)
    assert not session.skipped
    lines = []
    for reading in session.readings:
        lines += lines_of(reading)
        if len(lines) == 2:
            lines += ["", ""]  # straight, and steered
        if reading == session.kept_gait_runs[0]:
            lines += [f"{reading.distance_m}"]  # the marks then stay where they are
    with SessionRobot("virtual:fast") as robot:
        heard, again = talk(folder, *lines, robot=robot)
    assert "Nothing of the plan is left to take; `serpenoid fit" in heard, heard
    assert len(again.kept_stations) == len(session.kept_stations)
    assert {run.distance_m for run in again.kept_gait_runs} == {
        session.kept_gait_runs[0].distance_m
    }
    assert len(lines) <= 90


def test_a_full_disk_keeps_what_was_typed_and_tries_again(folder, monkeypatch):
    from serpenoid.session import journal as module

    write, full = module.append_line, [True, True, False, False]

    def append(path, line):
        if full.pop(0):
            raise RecordingFailed("no room")
        write(path, line)

    monkeypatch.setattr(module, "append_line", append)
    heard, session = talk(folder, ZERO, "", "")
    assert heard.count("! no room") == 2
    assert "kept as reading 1" in heard
    assert len(session.readings_of("zero")) == 1


def test_no_station_is_planned_at_which_the_belt_would_carry_the_robot_off(folder):
    """The line through both stations is below 0.12 m/s at a third, less steep one."""
    heard, _ = talk(folder, ZERO, "", "2.39 0.556", "", "2.18 0.306", "", "quit")
    assert "Incline to about 2.1 deg" in heard
    assert "Incline to about 2.7 deg" in heard.partition("kept as reading 3")[2]


def test_the_offset_that_runs_straight_is_found_and_kept(folder):
    with SessionRobot("virtual:fast") as robot:
        lies = []

        def left():
            robot.steer(3)
            return ""

        def look():
            frame = list(robot._robot.frames(0.5))[-1]
            lies.extend(math.degrees(a) for a in frame.setpoint_rad)
            return "quit"

        _, session = talk(folder, ZERO, "", left, *STATION, look, robot=robot)
    assert lies == pytest.approx([0.75] * 5, abs=0.02)
    assert math.degrees(session.kept_stations[0].offset_rad) == pytest.approx(0.75)


@pytest.mark.parametrize(
    ("released", "off"),
    [
        (0, "pulses off (nobody has tried whether these servos go limp when pulses end)"),
        (1, "servos off"),
        (2, "pulses off (these servos hold when pulses end: only the switch stops them)"),
    ],
)
def test_when_nobody_answers_pulses_end_and_the_pose_is_taken_again(folder, released, off):
    link = VirtualLink(fast=True)
    link.board.eeprom = eeprom_after(f"set released {released}")
    link.board.boot("external")
    with SessionRobot(link) as seat:
        heard, _ = talk(folder, ZERO, "", "(nobody)", "", "pause", robot=seat)
        assert not seat.powered
    assert f"nobody answered for 300 s: {off}; the pose is to be taken again" in heard
    assert f"paused: {off}; the pose is to be taken again" in heard
    assert heard.count("Enter straightens the robot") == 3
    assert off in read_events(folder, [])[0].detail


def test_a_robot_that_is_lost_loses_no_reading(folder):
    with SessionRobot("virtual:fast") as seat:

        def lost():
            raise RobotLost("unplugged")

        heard, session = talk(folder, ZERO, "", "", *STATION, lost, robot=seat)
    assert "! the robot: unplugged" in heard
    assert len(session.kept_stations) == 1


@pytest.fixture
def floor(tmp_path):
    """A plan with a bend of 45 deg; one push each."""
    setup = default_setup("made up")
    plan = replace(on_place(setup.plan, "floor"), pushes=1, push_lambda_deg=(0, 20, 45))
    return create_session(tmp_path / "floor", replace(setup, plan=plan))


PUSH = ("1.0 2.4 0",)


def test_bends_and_gaits_beyond_a_joint_are_said_and_may_be_skipped(floor):
    link = VirtualLink(fast=True)
    link.board.eeprom = eeprom_after("trim 5 high 60")
    link.board.boot("external")
    bent = ("", "140", *PUSH)
    with SessionRobot(link) as seat:
        heard, _ = talk(floor, "", *PUSH, *bent, "", "skip", "", "skip", "skip", robot=seat)
    assert "! the board refuses 'pose" in heard
    assert "! the board refuses 'gait" in heard
    assert "Nothing of the plan is left to take" in heard
