"""The dialogue with a made-up person: every word at every prompt, typos, nobody there, a robot."""

import math
from collections import deque
from dataclasses import replace
from pathlib import Path

import pytest
from robot.fake_board import eeprom_after
from serpenoid import Ground, fit_friction
from serpenoid.calibration.session_rows import read_events
from serpenoid.calibration.taking.journal import Journal
from serpenoid.calibration.taking.new_session import create_session, default_setup, on_place
from serpenoid.calibration.taking.person.dialogue import Dialogue, held_dialogue
from serpenoid.calibration.taking.person.session_robot import SessionRobot
from serpenoid.calibration.taking.simulated import SimulatedPerson, Truth
from serpenoid.model.errors import RobotHeld, RobotLost
from serpenoid.robot.wire.virtual import VirtualLink


class Person:
    """Types prepared lines, then leaves; None stands for not answering in time."""

    def __init__(self, *lines):
        self.lines = deque(lines)
        self.heard = ""

    def say(self, text):
        self.heard += text + "\n"

    def forget(self):
        pass

    def ask(self, prompt, patience_s, tick):
        self.heard += prompt + "\n"
        tick()
        if not self.lines:
            raise EOFError
        line = self.lines.popleft()
        return line() if callable(line) else line


@pytest.fixture
def folder(tmp_path) -> Path:
    return create_session(tmp_path / "session", default_setup("made up"))


def talk(folder, *lines, robot=None, **given):
    """Return what a person heard, and the session afterwards."""
    person = Person(*lines)
    with Journal(folder) as journal:
        held_dialogue(Dialogue(journal, person, robot, patience_s=5, **given), person)
        return person.heard, journal.session


def leave_out(folder, *keys):
    with Journal(folder) as journal:
        for key in keys:
            journal.event("skip", detail=key)


ZERO = ("0,1", "-0.1")
# belt set, incline, belt, turned, drift, "only 0 s of 16" kept
STATION = ("", "2.0", "0.2", "", "", "keep")


def station(incline, belt, drift=""):
    return ("", incline, belt, "", drift, "keep")


def test_a_few_steps_by_hand(folder):
    heard, session = talk(folder, *ZERO, "", *STATION, *station("2.3", "0.5", "0.01"))
    assert [z.zero_rad for z in session.zeros] == [0.0]
    assert [(r.belt_speed_m_s, r.drift_m_s) for r in session.kept] == [(0.2, 0.0), (0.5, 0.01)]
    assert "head downhill" in heard
    assert "wait 16 s" in heard
    assert "only 0 s of 16" in heard
    assert heard.endswith("Everything read so far is kept; the same command goes on from here.\n")
    heard, _ = talk(folder)
    assert "Inclinometer zero" not in heard  # it goes on, posing anew


def test_a_station_too_slow_for_the_law_is_asked_about(folder):
    slow = ("", "2.0", "0.10", "", "", "keep", "again")
    heard, session = talk(folder, *ZERO, "", *slow, *station("2.0", "0.16", "0.05"), "keep")
    assert heard.count("friction is not that of the law") == 2
    assert "expected 0.12 to" in heard
    assert [r.belt_speed_m_s for r in session.kept] == [0.16]


class Led:
    """Reads off a simulated treadmill what each prompt asks for."""

    def __init__(self, setup):
        truth = Truth(Ground(0.084, 1.2, 0.14, 0.27), incline_zero_rad=math.radians(0.1))
        self.treadmill = SimulatedPerson(setup, truth, seed=4)
        self.heard, self.cells = "", {}

    def told(self, session, step):
        self.step = step
        self.cells = {} if step.kind == "done" else self.treadmill.answer(step, session)

    def say(self, text):
        self.heard += text + "\n"

    def forget(self):
        pass

    def ask(self, prompt, patience_s, tick):
        tick()
        self.heard += prompt + "\n"
        if self.cells is None:
            return "skip"
        if "keep" in prompt:
            return "keep"
        asked = [f for f in self.step.fields if prompt == f"  {f.words} ({f.unit}): "]
        told = [self.cells[f.column] for f in asked if f.column in self.cells]
        return f"{told[0]:g}".replace(".", ",") if told else ""


def test_it_leads_through_all_of_a_session_with_the_robot(folder):
    """What comes out is what the script takes without a person: the same procedure."""
    with SessionRobot("virtual:fast") as seat, Journal(folder) as journal:
        journal.event("amend", detail="plan.gait_runs = 1")
        person = Led(journal.session.setup)
        assert held_dialogue(Dialogue(journal, person, seat, person.told), person)
        session = journal.session
        assert seat._robot.status().state == "idle"
    assert person.heard.rstrip().endswith("all of the plan is done")
    assert {round(math.degrees(b.lambda_rad), 1) for b in session.bends} == {7.5, 15, 30}
    assert len(session.zeros) == 2
    assert len(session.kept_gait_runs) == 3
    for row, true in zip(fit_friction(session).rows(), (0.084, 1.2, 0.14, 0.27), strict=True):
        assert abs(row.value - true) < 3.5 * row.sigma


def test_comma_decimals_units_and_nonsense(folder):
    talk(folder, *ZERO, "", *STATION, *station("2.3", "1,8 km/h"))
    heard, session = talk(
        folder,
        "",
        "",
        "two",
        "nan",
        "2;6",
        "2.6",
        "8000",
        "1e3",
        "2.9 knots",
        "0.8",
        "",
        "",
        "keep",
    )
    assert "'two' is no number; type a number in deg or %, such as 2.3 or 4 %" in heard
    assert heard.count("is no number") == 2
    assert heard.count("is no unit of this") == 2
    assert "8000 m/s cannot be: belt speed is 0 to 10 m/s" in heard
    assert "1000 m/s is outside 0.312 to 1.29 m/s; did you mean 1000 mm/s = 1 m/s?" in heard
    assert [r.belt_speed_m_s for r in session.kept] == [0.2, 0.5, 0.8]


def test_a_slip_of_units_is_seen_by_its_range_and_asked(folder):
    talk(folder, *ZERO, "", *STATION, *station("2.3", "0.5"))
    heard, session = talk(folder, "", "", "4.5", "", "y", "2.8", "yes", "", "", "keep")
    assert heard.count("did you mean 4.5 %") == 2  # Enter answers nothing
    assert "did you mean 4.5 % = 2.577 deg?" in heard
    assert "did you mean 2.8 km/h = 0.7778 m/s?" in heard
    reading = session.kept[-1]
    assert math.degrees(reading.incline_rad) == pytest.approx(2.5766, abs=1e-4)
    assert reading.belt_speed_m_s == pytest.approx(0.77778, abs=1e-5)


def test_what_is_out_of_line_is_asked_about_and_may_be_kept(folder):
    talk(folder, *ZERO, "", *STATION, *station("2.3", "0.5"))
    # Neither Enter nor the same number again keeps it: the word does.
    heard, session = talk(folder, "", *station("2.6", "0.05"), "", "0.05", "keep")
    assert heard.count("belt speed 0.05 m/s: expected") == 3
    assert session.kept[-1].belt_speed_m_s == 0.05
    heard, session = talk(folder, "undo", "", *station("2.6", "0.05"), "0.8")
    assert session.kept[-1].belt_speed_m_s == 0.8


def test_a_zero_whose_sign_was_forgotten_is_questioned(folder):
    heard, session = talk(folder, "0.6", "0,6", "", "-0.6")
    assert "turned, it shows 0.6 deg: expected -1.6 to 0.4" in heard
    assert "was a sign forgotten?" in heard
    assert [z.zero_rad for z in session.zeros] == [pytest.approx(0.0, abs=1e-9)]
    heard, _ = talk(folder, "undo", "skip")
    assert "without a zero, 0.1 deg that nobody sees is 6 %" in heard


def test_the_belt_is_checked_at_the_end(folder):
    leave_out(folder, "bend 7.5", "bend 15", "bend 30", "gait 1", "gait 2", "gait 3")
    talk(folder, *ZERO, "", *STATION, *station("2.3", "0.5"), *station("2.6", "0.8"))
    heard, session = talk(folder, *ZERO, "1,8 km/h", "28", "50")
    assert "mark the belt's edge" in heard
    assert session.of("belt")[0].scale == pytest.approx(1.12)
    assert "all of the plan is done" in heard


def test_a_robot_that_turned_is_held_again(folder):
    turned = ("", "2.0", "0.2", "12", "", "keep")
    heard, session = talk(folder, *ZERO, "", *turned, "again", *STATION)
    assert "turned off the belt's direction, + to the left (Enter: not) 12 deg: expected" in heard
    assert "is not held by this law: hold it again" in heard
    assert [r.turned_rad for r in session.kept] == [0.0]
    heard, session = talk(folder, "undo", "", *turned, "keep")
    assert math.degrees(session.kept[0].turned_rad) == pytest.approx(12.0)


def test_settling_counts_from_the_moment_that_the_belt_was_set_by_its_clock(folder):
    now = [1000.0]

    def later():
        now[0] += 15.0
        return "2.0"

    def by(*lines):
        return talk(folder, *lines, clock_s=lambda: now[0])

    heard, session = by(*ZERO, "", "", later, "0.2", "", "")
    assert "since the belt was set" not in heard
    assert [r.waited_s for r in session.kept] == [15.0]
    # Somebody who pressed Enter late says how long it really ran.
    heard, session = by("", "", "2.3", "0.5", "", "", "long", "20 s")
    assert "only 0 s of 16 since the belt was set" in heard
    assert "'long' is no number" in heard
    assert session.kept[-1].waited_s == 20.0


def test_undo_redo_void_and_restore(folder):
    _, session = talk(folder, *ZERO, "", *STATION, *station("2.3", "0.5"), "undo")
    assert [r.number for r in session.kept] == [2]
    heard, session = talk(folder, "redo 2", "", "0.25", "", "")
    assert [(r.number, r.belt_speed_m_s) for r in session.kept] == [(4, 0.25)]
    assert session.kept[0].incline_rad == pytest.approx(math.radians(2.0))
    _, session = talk(folder, "undo")  # brings back the one that was redone
    assert [r.number for r in session.kept] == [2]
    _, session = talk(folder, "void 2 slipped", "restore 3")
    assert [r.number for r in session.kept] == [3]
    # Redone after it was restored, the new one alone counts, whatever the clock says.
    _, session = talk(folder, "restore 2", "redo 2", "", "0.22", "", "")
    assert [(r.number, r.belt_speed_m_s) for r in session.kept] == [(3, 0.5), (5, 0.22)]
    _, session = talk(folder, "undo", "restore 2")
    assert [r.number for r in session.kept] == [2, 3]
    talk(folder, "void 2")
    heard, _ = talk(folder, "void seven", "redo 77", "void")
    assert heard.count("is no reading's number; there are 1 to 5") == 3
    assert "'seven'" in heard


def test_skip_and_its_undoing(folder):
    heard, _ = talk(folder, "undo", "skip", "skip", "skip", "undo", "", "skip", "undo")
    assert "there is no reading yet" in heard
    assert "left out: zero before" in heard
    assert "no longer left out: station at 2.40 deg, straight" in heard
    assert "all of the straight stations, without which nothing can be fitted" in heard
    assert "no longer left out: straight\n" in heard
    assert [e.event for e in read_events(folder)] == ["skip", *["skip", "unskip"] * 2]


def test_a_skip_that_leaves_out_more_than_was_asked_is_doubted_once(folder):
    pose, turned, drift = (("skip", ""),) * 3
    heard, session = talk(folder, *ZERO, *pose, "", "2.0", "0.2", *turned, *drift, "keep")
    assert "! skip leaves out all of the straight stations, not only this pose" in heard
    assert heard.count("! skip leaves out the whole reading, with what was typed") == 2
    assert not read_events(folder)
    assert [r.turned_rad for r in session.kept] == [0.0]
    heard, session = talk(folder, "", "", "2.3", "0.5", "", "skip", "skip")
    assert "left out: station at" in heard
    assert len(session.kept) == 1


def test_undo_after_a_reading_voids_it_and_leaves_an_old_skip(folder):
    heard, session = talk(folder, "skip", "", *STATION, "undo")
    assert "reading 1 is void" in heard
    assert "no longer left out" not in heard
    assert not session.kept
    assert [e.event for e in read_events(folder)] == ["skip", "undo"]


def test_undoing_a_skip_heeds_no_clock(folder, monkeypatch):
    from serpenoid.calibration.taking import journal as module

    talk(folder, *ZERO, "", *STATION)
    monkeypatch.setattr(module, "utc_now", lambda: "2001-02-03T04:05:06.007Z")
    heard, session = talk(folder, "", "skip", "undo")
    assert "no longer left out: station at" in heard
    assert len(session.kept) == 1


def test_ctrl_c_says_that_all_is_kept(folder):
    def interrupt():
        raise KeyboardInterrupt

    person = Person(*ZERO, interrupt)
    with Journal(folder) as journal, pytest.raises(KeyboardInterrupt):
        Dialogue(journal, person).run()
    assert "Everything read so far is kept" in person.heard


def test_pause_note_status_help_and_quit(folder):
    heard, _ = talk(folder, *ZERO, "note warm room", "status", "help", "pause", "", "quit", "2.0")
    assert "zero before   done" in heard
    assert "redo [N]" in heard
    assert "paused. Enter goes on" in heard
    found = [(e.event, e.detail) for e in read_events(folder)]
    assert found == [("note", "warm room"), ("pause", ""), ("resume", "")]


def test_a_full_disk_is_told_and_the_next_reading_kept(folder, monkeypatch):
    from serpenoid.calibration.taking import journal as module

    real, full = module.append_line, [True]

    def append(path, line):
        if full.pop() if full else False:
            raise module._full(path, OSError(28, "No space left on device"))
        real(path, line)

    monkeypatch.setattr(module, "append_line", append)
    heard, session = talk(folder, *ZERO, *ZERO)
    assert "No space left on device: this is not saved, all before it is" in heard
    assert len(session.zeros) == 1


def test_steering_is_slow_and_poses_are_as_quick_as_the_board_has_it():
    with SessionRobot("virtual:fast") as robot:
        board, speeds = robot._robot, []
        speeds.append(board.settings()["pose_speed"])
        robot.pose(7.5)
        speeds.append(board.settings()["pose_speed"])
        robot.pose(0.0)
        robot.steer(1)
        speeds.append(board.settings()["pose_speed"])
        robot.idle()
        speeds.append(board.settings()["pose_speed"])
    assert speeds == [45.0, 2.0, 2.0, 45.0]


def test_the_offset_that_runs_straight_is_found_kept_and_resumed(folder):
    def left(robot, times):
        def press():
            robot.steer(times)
            return ""

        return press

    def joints(robot):
        frame = list(robot._robot.frames(0.5))[-1]
        return [math.degrees(a) for a in frame.setpoint_rad]

    with SessionRobot("virtual:fast") as robot:
        lies = []

        def look():
            lies.append(joints(robot))
            return "quit"

        heard, session = talk(folder, *ZERO, "", left(robot, 3), *STATION, look, robot=robot)
    assert lies == [pytest.approx([0.75] * 5, abs=0.02)]
    assert "every joint has +0.75 deg from now on" in heard
    assert math.degrees(session.kept[0].offset_rad) == pytest.approx(0.75)
    leave_out(folder, "straight")
    with SessionRobot("virtual:fast") as robot:
        heard, _ = talk(folder, "", left(robot, -1), look, robot=robot)
    assert "steer until the robot runs straight" not in heard  # it is known
    assert lies[1] == pytest.approx([-14.5, 8.0, 0.5, -7.0, 15.5], abs=0.02)


def test_skip_leaves_out_the_steering_alone(folder):
    with SessionRobot("virtual:fast") as robot:
        heard, session = talk(folder, *ZERO, "", "skip", *STATION, robot=robot)
    assert heard.count("Enter straightens") == 1
    assert session.kept


def test_steering_beyond_a_joint_leaves_the_pose(folder):
    with SessionRobot("virtual:fast") as robot:
        assert robot.steer(1) == "+0.00 deg on every joint"  # nothing is posed
        robot.pose(30.0)
        robot.steer(40)
        kept = robot.steer(0)
        assert kept == "+10.00 deg on every joint"
        assert robot.steer(4000).startswith("not steered: the board refuses")
        robot.idle()
        assert robot.steer(1) == kept


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
        heard, _ = talk(folder, *ZERO, "", None, lambda: str(seat.powered), "pause", robot=seat)
        assert not seat.powered
    assert f"nobody answered for 5 s: {off}; the pose is to be taken again" in heard
    assert f"paused; {off}. Enter goes on" in heard
    assert heard.count("Enter straightens the robot") == 2
    assert off in read_events(folder)[0].detail


def test_a_robot_that_is_lost_loses_no_reading(folder):
    with SessionRobot("virtual:fast") as seat:

        def lost():
            raise RobotLost("unplugged")

        heard, session = talk(folder, *ZERO, "", "", *STATION, lost, robot=seat)
    assert "! the robot: unplugged" in heard
    assert len(session.kept) == 1


def test_a_gait_run_with_the_robot(folder):
    leave_out(folder, "straight", "bend 7.5", "bend 15", "bend 30")
    with SessionRobot("virtual:fast") as seat:
        moved = []

        def time_taken():
            moved.append(seat._robot.status().state)
            return "10"

        heard, session = talk(folder, *ZERO, "", "1.0", time_taken, robot=seat)
        assert seat._robot.status().state == "idle"
    assert moved == ["gait"]
    assert session.gait_runs[0].speed_m_s == pytest.approx(0.1)
    assert session.gait_runs[0].omega_rad_s == pytest.approx(math.pi / 2, rel=0.01)
    assert "Enter starts the robot" in heard


def test_a_stop_from_the_page_lets_the_servos_go_and_says_so(folder):
    with SessionRobot("virtual:fast") as seat:

        def stop():
            seat.halt()
            return "status"

        # The Enters that follow release nothing; only the word does.
        heard, _ = talk(folder, *ZERO, "", stop, "", "", "2.0", robot=seat)
        assert not seat.powered
        with pytest.raises(RobotHeld):
            seat._robot.straight()
    assert "stopped from the page: pulses off (nobody has tried" in heard
    assert heard.count("type release") == 4
    assert heard.count("Enter straightens the robot") == 1


def test_released_at_the_terminal_it_moves_again(folder):
    with SessionRobot("virtual:fast") as seat:
        seat.halt()
        powered = []

        def last():
            powered.append(seat.powered)
            return "quit"

        heard, _ = talk(folder, *ZERO, "status", "release", "", last, robot=seat)
        assert powered == [True]
        assert not seat.held
    assert heard.count("type release") == 2
    notes = [e.detail for e in read_events(folder) if e.event == "note"]
    assert notes == ["stopped from the page", "released at the terminal"]


@pytest.fixture
def floor(tmp_path):
    """A session of before, with a bend of 45 deg; one push each."""
    setup = default_setup("made up")
    bends = tuple(map(math.radians, (0, 20, 45)))
    plan = replace(on_place(setup.procedure, "floor"), pushes=1, push_lambda_rad=bends)
    return create_session(tmp_path / "floor", replace(setup, procedure=plan))


PUSH = ("1.0", "2.4", "")


def test_on_a_floor_steering_is_kept_and_a_bend_leaves_room_for_it(floor):
    with SessionRobot("virtual:fast") as robot:

        def pushed(steps):
            return lambda: robot.steer(steps) and PUSH[0]

        first = ("", pushed(2), *PUSH[1:], "skip", "", "90.5", "quit")
        heard, _ = talk(floor, *first, robot=robot)
    assert "belt" not in heard
    assert "steer against it before the next" in heard
    assert "left out: pushes, bend 20 deg" in heard
    assert heard.count("Bend 20 deg") == 1
    with SessionRobot("virtual:fast") as robot:
        again, session = talk(floor, "", "90.5", pushed(-1), *PUSH[1:], robot=robot)
    for said in (heard, again):
        assert "room for 44.75 deg: it is bent so far" in said
    assert [math.degrees(p.offset_rad) for p in session.kept_pushes] == [0.5, 0.25]
    assert [math.degrees(p.lambda_rad) for p in session.kept_pushes] == [0, 44.75]


def test_bends_and_gaits_beyond_a_joint_are_said_and_may_be_skipped(floor):
    link = VirtualLink(fast=True)
    link.board.eeprom = eeprom_after("trim 5 high 60")
    link.board.boot("external")
    bent = ("", "140", *PUSH)
    with SessionRobot(link) as seat:
        heard, _ = talk(floor, "", *PUSH, *bent, "", "skip", "", "skip", "skip", robot=seat)
    far = "bend 45 deg: joint limits and steering leave room for 30 deg"
    assert heard.index(far) < heard.index("On the floor, robot straight")
    assert heard.count(far) == 3  # at the start, and at the step until it is skipped
    assert "Enter bends the robot" not in heard.partition("Bend 45 deg")[2]
    assert "! the board refuses 'gait" in heard
    assert heard.endswith("all of the plan is done\n")
