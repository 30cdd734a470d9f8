"""`serpenoid calibrate DIR` at a terminal, driven as a person would; killed, and resumed."""

import math
import signal

import pytest
from command_line import serpenoid
from robot.terminal import Person
from serpenoid import load_session
from serpenoid.session.folder import read_events, read_session


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "session"
    serpenoid(f"calibrate new {path} --defaults --surface belt --mass-kg 0.4536")
    return path


def test_taken_killed_and_resumed_at_a_terminal(folder):
    with Person(f"calibrate {folder} --port virtual") as person:
        person.answers("it shows", "0,1\n0.0\n")
        person.answers("Enter straightens the robot", "\n")
        person.answers("Steer until it runs straight", "\x1b[D\x1b[D\x1b[C\x1b[D")
        person.answers("+0.50 deg on every joint", "\n")
        person.answers("the inclinometer shows", "héllo\n2.1\x7f0\n")
        person.answers("belt speed", "9\x7f0.05\n")
        person.answers("drift left over", "\n")
        person.answers("anew, or keep", "\n")
        person.answers("anew, or keep", "keep\n")
        person.sees("kept as reading 2")
        person.sends(signal.SIGKILL)
        person.leaves()
    (reading,) = load_session(folder).kept_stations
    assert math.degrees(reading.offset_rad) == pytest.approx(0.5)
    assert (math.degrees(reading.incline_rad), reading.belt_speed_m_s) == (pytest.approx(2.0), 0.05)
    with Person(f"calibrate {folder}") as person:
        person.sees("1 station")
        person.sees("on belt: 6 links of 76 mm, 453.6 g")
        person.answers("Enter if it is this robot", "\n")
        person.answers("Robot straight", "quit\n")
        person.sees("Everything read so far is kept")
        assert person.leaves() == 0


def test_the_end_of_the_input_leaves_the_session_whole(folder):
    with Person(f"calibrate {folder}") as person:
        person.answers("turned, it shows (deg): ", "\x04")
        person.sees("Left.")
        assert person.leaves() == 0
    assert read_session(folder).notes == ()
    assert [e.event for e in read_events(folder, [])].count("end") == 1


def test_a_new_session_asks_what_it_needs(tmp_path):
    with Person(f"calibrate new {tmp_path}/asked") as person:
        person.answers("what the wheels roll on", "rubber belt\n\n")
        person.answers("length of a link", "80 mm\n")
        person.answers("joints: each is off straight by", "1.5\n")
        person.answers("mass of the whole robot", "heavy\n")
        person.answers(
            "'heavy' is no number; type a number in kg or g or lb, such as 0.48 or 480 g", "760\n"
        )
        person.answers("as it crawls: 760 kg; expected 0.02 to 20 kg", "undo\n")
        person.answers("mass of the whole robot", "480\n")
        person.answers("480 kg; expected 0.02 to 20 kg", "keep\n")
        person.answers("heavier than solid metal", "480 g\n")
        person.answers("voltage at their plug", "5,2 V\n\n")
        person.answers("smallest step of its incline", "0,5 deg\n")
        person.answers("unit of the belt's speed", "mph\n")
        person.answers("smallest step it can be set to", "0.1\n")
        person.sees("begun:")
        assert person.leaves() == 0
    setup = read_session(tmp_path / "asked").setup
    assert setup.laboratory.surface == "rubber belt"
    assert setup.robot.link_mass_kg == pytest.approx(0.08)
    assert setup.robot.link_length_m == pytest.approx(0.08)
    assert setup.robot_table.supply_v == 5.2
    assert setup.instruments.incline_step_rad == pytest.approx(0.0087269, rel=1e-4)
    assert setup.instruments.belt_speed_step_m_s == pytest.approx(0.044704)
    assert setup.instruments.belt_speed_unit == "mph"
    assert math.degrees(setup.instruments.joint_sigma_rad) == pytest.approx(1.5)


def test_enter_at_the_mass_weighs_nothing_and_undo_asks_again(tmp_path):
    with Person(f"calibrate new {tmp_path}/asked") as person:
        person.answers("what the wheels roll on", "belr\nundo\nbelt\n7\nundo\n6\n\nskip\n")
        person.answers(
            "mass of the whole robot as it crawls (kg, or 480 g; later) [later]",
            "help\n" + 6 * "\n",
        )
        person.sees("begun:")
        assert person.leaves() == 0
    session = read_session(tmp_path / "asked")
    assert session.setup.laboratory.surface == "belt"
    assert session.setup.robot.links == 6
    assert session.setup.robot_table.mass_kg is None
    assert session.setup.mass_sigma == 0.05


def test_a_new_session_has_an_answer_to_words_that_take_nothing_back(tmp_path):
    with Person(f"calibrate new {tmp_path}/asked") as person:
        person.answers("what the wheels roll on", "undo\n")
        person.answers("nothing was asked before this", "belt\n" + 3 * "\n")
        person.answers("mass of the whole robot", "480\n")
        person.answers("480 kg; expected 0.02 to 20 kg", "skip\n")
        person.answers("a number in doubt cannot be left out", "quit\n")
        assert person.leaves() == 0


def test_who_leaves_a_new_session_writes_nothing(tmp_path):
    for keys, status in (("belt\nquit\n", 0), ("\x04", 0), ("\x03", 130)):
        with Person(f"calibrate new {tmp_path}/asked") as person:
            person.answers("what the wheels roll on", keys)
            assert person.leaves() == status
        assert not (tmp_path / "asked").exists()
