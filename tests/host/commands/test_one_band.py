"""All commands show the same band for a gait, and all show the alarms of a fit."""

from __future__ import annotations

import json
import math
import shutil

import pytest
from command_line import serpenoid
from planned import replan
from robots import NIRAKH_2005
from serpenoid import load_session
from serpenoid.session.journal import Journal

GAIT = "--alpha-deg 70 --beta-deg 75 --frequency-hz 0.5"
GAIT_IN_DEGREES = "--gait 70 75 0.5"
SWEEP = "--alpha-deg 70 --beta-deg 75 --omega-rad-s 3"
IDEAL_SERVO = "--servo ideal"


def run_json(line):
    """Run a command with --json; return its answer and its warnings."""
    result = serpenoid(f"{line} --json", check=True)
    return json.loads(result.stdout[result.stdout.index("{") :]), result.stderr


def session_with_plan(folder):
    """Return the session of 2005 in a folder whose plan has GAIT and a slower gait."""
    serpenoid(f"calibrate new --defaults {folder}", check=True)
    shape = {"alpha_deg": 70, "beta_deg": 75}
    replan(folder, gaits=[shape | {"frequency_hz": hz} for hz in (0.25, 0.5)])
    with Journal(folder) as journal:
        for r in load_session(NIRAKH_2005).readings:
            bend, incline = math.degrees(r.lambda_rad), math.degrees(r.incline_rad)
            journal.add(
                "station",
                {
                    "lambda_deg": bend,
                    "incline_deg": incline,
                    "belt_speed_m_s": r.belt_speed_m_s,
                    "drift_m_s": r.drift_m_s,
                },
            )
    return folder


@pytest.mark.slow
def test_all_commands_show_the_same_band(tmp_path):
    session = session_with_plan(tmp_path / "session")
    robot_option = f"--robot {session} {IDEAL_SERVO}"
    steady = run_json(f"steady {robot_option} {GAIT}")[0]["band"]
    low, high, speed = (steady[f"{name}_m_s"] for name in ("low", "high", "speed"))
    assert 0.3 * speed < low < steady["low_friction_m_s"] < speed
    assert speed < steady["high_friction_m_s"] < high
    driven = run_json(f"drive {robot_option} {GAIT} --port virtual:fast --duration-s 1")[0]
    assert driven["predicted"] == steady
    rows = run_json(f"compare {session} {GAIT_IN_DEGREES} {IDEAL_SERVO}")[0]["gaits"]
    rates = [round(row["frequency_hz"], 6) for row in rows]
    assert rates == [0.25, 0.5]  # each gait is listed once
    compared = rows[1]
    ends = ("low_m_s", "high_m_s", "low_friction_m_s", "high_friction_m_s")
    assert [compared[end] for end in ends] == pytest.approx([steady[end] for end in ends], rel=1e-6)
    advised = run_json(f"advise {session} {GAIT_IN_DEGREES} {IDEAL_SERVO}")[0]
    assert advised["band"] == pytest.approx((high - low) / 2 / speed, rel=1e-6)
    page = tmp_path / "report.html"
    serpenoid(f"report {session} {IDEAL_SERVO} --out {page}", check=True)
    assert f"<td>{low:.3g} to {high:.3g}</td>" in page.read_text()
    planned = run_json(f"advise {session} {IDEAL_SERVO}")[0]["band"]
    assert f"±{100 * planned:.2g} %" in page.read_text()
    best = run_json(f"optimize {robot_option} --speed-m-s 0.05")[0]
    gait = " ".join(
        f"--{name.replace('_', '-')}={best['gait'][name]}"
        for name in ("alpha_deg", "beta_deg", "omega_rad_s")
    )
    repeated, band = run_json(f"steady {robot_option} {gait}")[0]["band"], best["band"]
    ends = ["low_m_s", "high_m_s", "speed_m_s"]
    assert [repeated[end] for end in ends] == pytest.approx([band[end] for end in ends], rel=1e-4)


@pytest.fixture
def contradictory(tmp_path):
    """Return the session of 2005 with one incline misread, and the number of that reading."""
    shutil.copytree(NIRAKH_2005, tmp_path / "session")
    path = tmp_path / "session" / "readings.csv"
    rows = path.read_text().splitlines()
    cells = rows[3].split(",")
    column = rows[0].split(",").index("incline_deg")
    cells[column] = f"{2 * float(cells[column]):.2f}"
    path.write_text("\n".join([*rows[:3], ",".join(cells), *rows[4:]]) + "\n")
    return tmp_path / "session", cells[0]


@pytest.mark.slow
def test_all_commands_show_the_alarms_of_a_fit(contradictory, tmp_path):
    folder, number = contradictory
    robot_option = f"--robot {folder}"
    lines = (
        f"fit {folder}",
        f"compare {folder} {GAIT_IN_DEGREES} {IDEAL_SERVO} --set samples=16",
        f"advise {folder} {GAIT_IN_DEGREES} {IDEAL_SERVO} --set samples=16",
        f"optimize {robot_option} {IDEAL_SERVO} --speed-m-s 0.05",
        f"steady {robot_option} {GAIT} {IDEAL_SERVO}",
        f"simulate {robot_option} {GAIT} --duration-s 0.2",
        f"sweep {robot_option} {SWEEP} --out {tmp_path / 'study.csv'}",
        f"drive {robot_option} {GAIT} {IDEAL_SERVO} --port virtual:fast --duration-s 1",
    )
    for line in lines:
        answer, warnings = run_json(line)
        if line.startswith("fit"):  # the command whose own answer has the alarms
            assert f"Without reading {number} " in answer["alarms"][0]
            continue
        assert f"Without reading {number} " in answer["fit_alarms"][0], line
        assert f"Without reading {number} " in " ".join(warnings.split()), line
    messages = serpenoid(f"report {folder} {IDEAL_SERVO}", check=True).stderr
    for text in (" ".join(messages.split()), (folder / "report.html").read_text()):
        assert f"Without reading {number} " in text
