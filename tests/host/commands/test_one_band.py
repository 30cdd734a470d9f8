"""One gait has one band, whoever shows it; and a fit that nobody may trust is told by all."""

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
WISH = "--gait 70 75 0.5"
IDEAL = "--servo ideal"


def told(line):
    """Return the answer of a command, and what it warned of."""
    done = serpenoid(f"{line} --json", check=True)
    return json.loads(done.stdout[done.stdout.index("{") :]), done.stderr


def with_a_plan(folder):
    """Return the session of 2005 in a folder whose plan has GAIT and another gait."""
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
def test_one_gait_has_one_band_whoever_shows_it(tmp_path):
    session = with_a_plan(tmp_path / "session")
    of = f"--robot {session} {IDEAL}"
    steady = told(f"steady {of} {GAIT}")[0]["band"]
    low, high, speed = (steady[f"{name}_m_s"] for name in ("low", "high", "speed"))
    assert 0.3 * speed < low < steady["low_friction_m_s"] < speed
    assert speed < steady["high_friction_m_s"] < high
    driven = told(f"drive {of} {GAIT} --port virtual:fast --duration-s 1")[0]
    assert driven["predicted"] == steady
    rows = told(f"compare {session} {WISH} {IDEAL}")[0]["gaits"]
    rates = [round(row["frequency_hz"], 6) for row in rows]
    assert rates == [0.25, 0.5]  # none is there twice
    compared = rows[1]
    ends = ("low_m_s", "high_m_s", "low_friction_m_s", "high_friction_m_s")
    assert [compared[end] for end in ends] == pytest.approx([steady[end] for end in ends], rel=1e-6)
    advised = told(f"advise {session} {WISH} {IDEAL}")[0]
    assert advised["band"] == pytest.approx((high - low) / 2 / speed, rel=1e-6)
    page = tmp_path / "report.html"
    serpenoid(f"report {session} {IDEAL} --out {page}", check=True)
    assert f"<td>{low:.3g} to {high:.3g}</td>" in page.read_text()
    planned = told(f"advise {session} {IDEAL}")[0]["band"]
    assert f"±{100 * planned:.2g} %" in page.read_text()
    best = told(f"optimize {of} --speed-m-s 0.05")[0]
    gait = " ".join(
        f"--{name.replace('_', '-')}={best['gait'][name]}"
        for name in ("alpha_deg", "beta_deg", "omega_rad_s")
    )
    again, band = told(f"steady {of} {gait}")[0]["band"], best["band"]
    ends = ["low_m_s", "high_m_s", "speed_m_s"]
    assert [again[x] for x in ends] == pytest.approx([band[x] for x in ends], rel=1e-4)


@pytest.fixture
def contradictory(tmp_path):
    """Return the session of 2005 with one incline misread, and that reading's number."""
    shutil.copytree(NIRAKH_2005, tmp_path / "session")
    path = tmp_path / "session" / "readings.csv"
    rows = path.read_text().splitlines()
    cells, at = rows[3].split(","), rows[0].split(",").index("incline_deg")
    cells[at] = f"{2 * float(cells[at]):.2f}"
    path.write_text("\n".join([*rows[:3], ",".join(cells), *rows[4:]]) + "\n")
    return tmp_path / "session", cells[0]


@pytest.mark.slow
def test_a_fit_that_nobody_may_trust_is_told_by_all(contradictory, tmp_path):
    folder, number = contradictory
    of = f"--robot {folder}"
    lines = (
        f"fit {folder}",
        f"compare {folder} {WISH} {IDEAL} --set samples=16",
        f"advise {folder} {WISH} {IDEAL} --set samples=16",
        f"optimize {of} {IDEAL} --speed-m-s 0.05",
        f"steady {of} {GAIT} {IDEAL}",
        f"simulate {of} {GAIT} --duration-s 0.2",
        f"sweep {of} --alpha-deg 70 --beta-deg 75 --omega-rad-s 3 --out {tmp_path / 'study.csv'}",
        f"drive {of} {GAIT} {IDEAL} --port virtual:fast --duration-s 1",
    )
    for line in lines:
        answer, warned = told(line)
        if line.startswith("fit"):  # whose answer it is
            assert f"Without reading {number} " in answer["alarms"][0]
            continue
        assert f"Without reading {number} " in answer["fit_alarms"][0], line
        assert f"Without reading {number} " in " ".join(warned.split()), line
    said = serpenoid(f"report {folder} {IDEAL}", check=True).stderr
    for text in (" ".join(said.split()), (folder / "report.html").read_text()):
        assert f"Without reading {number} " in text
