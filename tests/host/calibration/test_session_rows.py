"""Session files of format 2: all kinds of readings, amendments, voids, and damaged lines."""

import math
import re
from pathlib import Path

import pytest
from refusals import refused
from robots import NIRAKH_2005
from serpenoid import fit_friction, load_session

READING_COLUMNS, EVENT_COLUMNS = (
    (NIRAKH_2005 / name).read_text().split("\n")[0].split(",")
    for name in ("readings.csv", "events.csv")
)

SETUP = """
format = 2
name = "made up"
program = "serpenoid 0.2.0"
created_utc = "2026-05-01T12:00:00Z"
[provenance]
kind = "measured"
source = "a test"
note = "a test"
[robot]
links = 6
mass_kg = 0.4536
link_length_m = 0.076
[laboratory]
surface = "rubber belt"
place = "a bench"
people = "nobody"
gravity_m_s2 = 9.80665
[instruments]
incline_sigma_deg = 0.03
incline_zero_sigma_deg = 0.1
belt_speed_sigma_m_s = 0.01
lambda_sigma_deg = 0.5
belt_speed_least_m_s = 0.2
[plan]
lambda_deg = [0.0, 15.0]
incline_start_deg = 2.0
incline_step_deg = 0.3
belt_speed_max_m_s = 1.0
gaits = [{ alpha_deg = 70.0, beta_deg = 75.0, omega_rad_s = 3.0 }]
"""
STATION = {
    "kind": "station",
    "setup": "1",
    "lambda_deg": "0",
    "incline_deg": "2.5",
    "belt_speed_m_s": "0.4",
    "drift_m_s": "0",
}
GAIT_RUN = {
    "kind": "gait",
    "alpha_deg": 70,
    "beta_deg": 75,
    "omega_rad_s": 3,
    "speed_m_s": 0.1,
    "speed_sigma_m_s": 0.002,
}


def line(columns, **cells):
    return ",".join(str(cells.get(name, "")) for name in columns) + "\n"


def reading(number, **cells):
    return line(READING_COLUMNS, reading=number, **STATION | cells)


STATIONS = [
    reading(k, lambda_deg=bend, incline_deg=2.0 + 0.3 * k, belt_speed_m_s=speed)
    for k, bend, speed in ((2, 0, 0.3), (3, 0, 0.6), (4, 15, 0.2), (5, 15, 0.5))
]


def event(what, number="", detail=""):
    return line(EVENT_COLUMNS, event=what, reading=number, detail=detail)


@pytest.fixture
def folder(tmp_path) -> Path:
    (tmp_path / "session.toml").write_text(SETUP)
    (tmp_path / "readings.csv").write_text(",".join(READING_COLUMNS) + "\n")
    (tmp_path / "events.csv").write_text(",".join(EVENT_COLUMNS) + "\n")
    return tmp_path


def append(folder, *lines, to="readings.csv"):
    with (folder / to).open("a") as file:
        file.write("".join(lines))


def test_every_kind_of_reading_is_loaded(folder):
    append(
        folder,
        reading(1, kind="zero", incline_deg="0.3", reversed_deg="-0.1"),
        reading(2),
        reading(3, kind="bend", lambda_deg="15", between_links_deg="149"),
        reading(4, lambda_deg="15.5"),
        reading(5, **GAIT_RUN),
        reading(6, kind="coastdown", more="height_mm=3"),
        reading(7, kind="zero", incline_deg="0.1", reversed_deg="0.3"),
    )
    session = load_session(folder)
    assert [r.number for r in session.kept_stations] == [2, 4]
    assert [b.number for b in session.readings_of("bend")] == [3]
    assert math.degrees(session.readings_of("bend")[0].found_rad) == pytest.approx(15.5)
    assert [z.at_start for z in session.readings_of("zero")] == [True, False]
    run = session.readings_of("gait")[0]
    assert (run.omega_rad_s, run.speed_m_s, run.speed_sigma_m_s) == (3.0, 0.1, 0.002)
    assert math.degrees(run.gait.beta_rad) == pytest.approx(75)
    assert re.search("1 reading of kinds not used here .coastdown.", session.notes[0])
    assert session.setup.laboratory.surface == "rubber belt"
    assert session.setup.instruments.belt_speed_least_m_s == 0.2
    assert session.folder == folder


def test_kinds_of_older_programs_are_left_out_with_a_note(folder):
    """An older file holds a slide, a breakaway test and a push timed at marks."""
    append(folder, *STATIONS)
    before = fit_friction(load_session(folder))
    marks = {"kind": "coast", "more": "by=marks track=tracks/0007.csv track_sha256=0"}
    append(
        folder,
        reading(6, kind="slide", distance_m=1, duration_s=2.1),
        reading(7, kind="breakaway"),
        reading(8, **marks),
    )
    session = load_session(folder)
    assert (
        "3 readings of kinds not used here (breakaway, push by marks, slide)" in (session.notes[0])
    )
    assert fit_friction(session).intervals == before.intervals


def test_a_moved_zero_adds_to_the_uncertainty(folder):
    zero = {"kind": "zero", "incline_deg": "0.3", "reversed_deg": "-0.1"}
    append(folder, reading(1, **zero), *STATIONS)
    fits = []
    for after in (zero, zero | {"incline_deg": "0.5", "reversed_deg": "0.1"}):
        append(folder, reading(6, **after))
        session = load_session(folder)
        fits.append(fit_friction(session))
        text = (folder / "readings.csv").read_text()
        (folder / "readings.csv").write_text(text[: text.rindex("6,zero")])
    constant, moved = fits
    assert math.degrees(session.zero.value_rad) == pytest.approx(0.2)
    assert math.degrees(session.zero.sigma_rad) == pytest.approx(math.hypot(0.015, 0.1))
    assert "zero moved" in " ".join(moved.notes)
    assert "zero moved" not in " ".join(constant.notes)
    assert moved.parameters["ft0"].sigma > 1.5 * constant.parameters["ft0"].sigma


def test_a_session_of_ratchet_wheels_is_refused(folder):
    append(folder, reading(1), reading(2, more="facing=up"))
    with refused("csv:3: reading 2 has facing=up: its wheels rolled backwards.*void"):
        load_session(folder)
    append(folder, event("void", 2), to="events.csv")
    plain = load_session(folder)
    toml = folder / "session.toml"
    toml.write_text(SETUP + "ratchet = false\n")
    assert load_session(folder).sha256 == plain.sha256
    toml.write_text(SETUP + "ratchet = true\n")
    with refused("session.toml:31: ratchet is True; a fit knows one friction"):
        load_session(folder)


def test_amendments_of_older_programs_apply_except_to_instruments_and_ratchets(folder):
    append(folder, reading(1, setup=2))
    append(folder, event("amend", detail='"robot.mass_kg = 0.5"'), to="events.csv")
    session = load_session(folder)
    assert session.setup.robot.mass_kg == pytest.approx(0.5)
    assert "older programs amended holds" in session.notes[0]
    for change, message in (
        ("instruments.time_sigma_s = 0.5", "one set of instruments.*correct it there"),
        ("plan.ratchet = true", "ratchet is True"),
        ("snake.links = 5", "is of 'snake'"),
        ("plan.lambda_deg = [90]", "lambda_deg is 90"),
        ("hm", "is not TOML"),
    ):
        path = folder / "events.csv"
        path.write_text(",".join(EVENT_COLUMNS) + "\n" + event("amend", detail=f'"{change}"'))
        with refused(message):
            load_session(folder)


def test_voided_restored_and_replaced_readings(folder):
    append(folder, reading(1), reading(2), reading(3), reading(4, replaces=2, belt_speed_m_s=0.5))
    append(
        folder,
        event("void", 1, "slipped"),
        event("void", 3, "slip"),
        event("restore", 3),
        to="events.csv",
    )
    session = load_session(folder)
    assert [(r.number, r.comment) for r in session.readings if r.voided] == [
        (1, "slipped"),
        (2, "redone as 4"),
    ]
    assert [r.number for r in session.kept_stations] == [3, 4]


def test_the_hash_depends_only_on_what_a_fit_uses(folder):
    append(folder, reading(1), reading(2))
    first = load_session(folder).sha256
    append(folder, event("note", detail="hello"), to="events.csv")
    append(folder, reading(3, **GAIT_RUN))
    assert load_session(folder).sha256 == first
    append(folder, event("void", 2), to="events.csv")
    assert load_session(folder).sha256 != first


def test_zero_bytes_after_a_power_cut_are_noted(folder):
    append(folder, reading(1), "2,station\0\0\0\0\n", reading(3))
    session = load_session(folder)
    assert [r.number for r in session.kept_stations] == [1, 3]
    assert any(":3: damaged (zero bytes" in note for note in session.notes)
