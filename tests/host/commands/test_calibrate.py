"""`serpenoid calibrate` without a person: begun, scripted, corrected, looked at, misused."""

import math
from pathlib import Path

import pytest
from command_line import answer, serpenoid
from planned import replan
from serpenoid import load_session
from serpenoid.session.folder import read_session

PLAN = "[simulated]\nseed = 3\nct = 0.084\ncn = 1.2\nft0 = 0.14\nfn0 = 0.27\n"


@pytest.fixture
def folder(tmp_path) -> Path:
    path = tmp_path / "session"
    assert calibrate(f"new {path} --defaults --simulated --surface belt")[0] == 0
    replan(path, gaits=[])
    return path


def calibrate(line):
    """Return status, output and errors of `serpenoid calibrate ...`."""
    return serpenoid(f"calibrate {line}")


@pytest.fixture
def plan(tmp_path) -> Path:
    path = tmp_path / "plan.toml"
    path.write_text(PLAN)
    return path


def test_a_script_takes_the_session_and_ends(folder, plan):
    status, out, _ = calibrate(f"{folder} --script {plan}")
    assert (status, "stations" in out) == (0, True)
    before = (folder / "readings.csv").read_bytes()
    assert len(load_session(folder).kept_stations) > 12
    assert load_session(folder).setup.provenance.kind == "simulated"
    assert calibrate(f"{folder} --script {plan}")[1].startswith("0 readings")
    assert (folder / "readings.csv").read_bytes() == before
    assert serpenoid(f"fit {folder}")[0] == 0


def test_listed_readings_are_added_once(folder, tmp_path):
    rows = [(0.0, 2.0, 0.2), (0.0, 2.3, 0.5)]
    text = "".join(
        f"[[reading]]\nlambda_deg = {bend}\nincline_deg = {incline}\nbelt_speed_m_s = {belt}\n"
        for bend, incline, belt in rows
    )
    path = tmp_path / "rows.toml"
    path.write_text(text)
    assert calibrate(f"{folder} --script {path}")[1].startswith("2 readings")
    assert calibrate(f"{folder} --script {path}")[1].startswith("0 readings")
    kept = load_session(folder).kept_stations
    assert [(r.belt_speed_m_s, r.drift_m_s) for r in kept] == [(0.2, 0.0), (0.5, 0.0)]
    # One of them voided, a reading by hand, the list grown: only what is new is added.
    calibrate(f"void {folder} 1")
    calibrate(f"add {folder} station lambda_deg=0 incline_deg=2.2 belt_speed_m_s=0.4")
    path.write_text(text + text.split("[[reading]]")[2].join(["[[reading]]", ""]))
    assert calibrate(f"{folder} --script {path}")[1].startswith("1 reading ")
    assert [r.belt_speed_m_s for r in load_session(folder).kept_stations] == [0.5, 0.4, 0.5]
    # A typed track that an older program kept in its row is there, too.
    places = "0:0 2:0.045 4:0.13"
    older = f"bend=balanced places={places.replace(' ', ',')} listed=0"
    with (folder / "readings.csv").open("a") as file:
        file.write(f'5,station,,1,,0,2.3,0.5,0.0325{"," * 10}"{older}",\n')
    path.write_text(text.split("[[reading]]")[2].join(["[[reading]]", f"places = '{places}'"]))
    assert calibrate(f"{folder} --script {path}")[1].startswith("0 readings")


def test_readings_are_added_replaced_and_voided(folder):
    cells = "lambda_deg=0 incline_deg=4% belt_speed_m_s=1,8km/h"
    assert calibrate(f"add {folder} station {cells}")[0] == 0
    assert "belt's speed was not checked" in calibrate(f"status {folder}")[1]
    reading = load_session(folder).kept_stations[0]
    assert reading.belt_speed_m_s == pytest.approx(0.5)
    assert reading.incline_rad == pytest.approx(0.0399787, abs=1e-6)  # atan 0.04
    status, out, _ = calibrate(f"add {folder} station {cells} drift_m_s=0.02 --replaces 1")
    assert (status, out) == (0, "reading 2 is kept; reading 1 is not\n")
    kept = load_session(folder).kept_stations
    assert [(r.number, r.drift_m_s, r.belt_speed_m_s) for r in kept] == [(2, 0.02, 0.5)]
    calibrate(f"void {folder} 2 --reason slipped")
    assert read_session(folder).readings[1].comment == "slipped"
    assert calibrate(f"add {folder} gait {GAIT} omega_rad_s=3.14")[0] == 0
    assert load_session(folder).readings_of("gait")[0].speed_m_s == pytest.approx(0.1)


GAIT = "alpha_deg=70 beta_deg=75 distance_m=1 duration_s=10"


def test_a_plan_and_a_script_take_hz(folder, tmp_path):
    """A planned gait, one of a list; each with exactly one rate."""
    toml = folder / "session.toml"
    plain = toml.read_text().replace("gaits = []\n", "")
    toml.write_text(f"{plain}gaits = [{{alpha_deg=70, beta_deg=75, frequency_hz=1}}]\n")
    assert read_session(folder).setup.plan.gaits[0].omega_rad_s == pytest.approx(math.tau)
    for rates in ("", ", frequency_hz=1, omega_rad_s=6"):
        toml.write_text(f"{plain}gaits = [{{alpha_deg=70, beta_deg=75{rates}}}]\n")
        status, _, err = calibrate(f"status {folder}")
        assert (status, "omega_rad_s and frequency_hz" in err) == (2, True), err
    toml.write_text(plain)
    row = "[[reading]]\nkind = 'gait'\nalpha_deg = 70\nbeta_deg = 75\nomega_rad_s = '0.5 Hz'\n"
    row += "speed_m_s = 0.1\nspeed_sigma_m_s = 0.01\n"
    script = tmp_path / "script.toml"
    other = row.replace("omega_rad_s", "frequency_hz"), "unknown column 'frequency_hz'"
    for text, says in ((row, ""), other):
        script.write_text(text)
        status, _, err = calibrate(f"{folder} --script {script}")
        assert (status, says in err) == (2 if says else 0, True), err
    assert load_session(folder).readings_of("gait")[0].omega_rad_s == pytest.approx(math.pi)


@pytest.mark.parametrize(
    ("cells", "says"),
    [
        ("incline_deg=two", "'two' is no number; type a number in deg or %"),
        ("incline_deg=nan", "'nan' is no number"),
        ("incline_deg=80", "80 deg cannot be"),
        ("'incline_deg=2.3 m'", "'m' is neither a number nor a unit of this"),
        (
            "gamma=2",
            "unknown column 'gamma'; a reading of kind station has",
        ),
        ("lambda_deg=0", "incline_deg is ''"),
    ],
)
def test_what_makes_no_sense_is_told_and_not_kept(folder, cells, says):
    before = (folder / "readings.csv").read_bytes()
    status, _, err = calibrate(f"add {folder} station {cells}")
    assert (status, says in err) == (2, True), err
    assert (folder / "readings.csv").read_bytes() == before


def test_status_tells_the_next_step_and_writes_nothing(folder):
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    told = calibrate(f"status {folder}")[1]
    assert "next: Inclinometer zero" in told
    assert "bend 15 " in told
    found = answer(f"calibrate status {folder}")
    assert found["parts"]["zero before"] == "open"
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before


def test_a_new_session_needs_answers_and_a_free_place(tmp_path, folder):
    status, _, err = calibrate(f"new {folder} --defaults")
    assert (status, "nothing overwrites it" in err) == (2, True)
    other = tmp_path / "other"
    assert "no terminal to ask at" in calibrate(f"new {other}")[2]
    assert calibrate(f"new {other} --template {folder}")[0] == 0
    assert read_session(other).setup.laboratory.surface == "belt"
    assert "no session here" in calibrate(f"void {tmp_path} 1")[2]


def test_a_mistyped_command_is_no_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, _, err = calibrate("statsu session")
    assert status == 2
    assert "nothing is called 'statsu'; 'status'?" in err
    (tmp_path / "statsu").mkdir()
    assert "no session here" in calibrate("statsu")[2]


def test_what_is_for_a_person_is_refused_where_nobody_is_asked(folder):
    status, *said = calibrate(f"{folder} --script {folder / 'session.toml'} --port virtual")
    assert status == 2
    assert "give one of --script and --port" in " ".join(said)
