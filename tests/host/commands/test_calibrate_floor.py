"""Sessions on a floor through the commands: new, pushes, a kill, continuation, advice, report."""

import re
from dataclasses import replace

import numpy as np
import pytest
from calibration.floor_sessions import NEW, TRUTH, push_track
from command_line import answer, serpenoid
from coverage_floor import CASES, drawn_person, floor_setup
from planned import replan
from serpenoid import load_session
from serpenoid.session.journal import Journal
from serpenoid.taking.new_session import create_session
from serpenoid.taking.simulated import take_all


def run(line, typed="", fails=False):
    """Run a command; return its output and messages as one line."""
    result = serpenoid(line, typed=typed)
    output = result.stdout + result.stderr
    assert (result.returncode != 0) == fails, output
    return " ".join(output.split())


@pytest.fixture
def tracks(tmp_path):
    """Return files of Tracker, in cm, of straight pushes forward and backward."""
    rng, paths = np.random.default_rng(1), []
    for k in range(4):
        rows = push_track(0.8 + 0.05 * k, TRUTH, rng, direction_rad=0.1 + np.pi * (k % 2))
        path = tmp_path / f"push{k}.txt"
        lines = [f"{t:.4E}\t{100 * x:.5E}\t{100 * y:.5E}" for t, x, y in rows]
        path.write_text("\n".join(["\tmass_A\t", "t\tx\ty", *lines]) + "\n")
        paths.append(path)
    return paths


def test_a_session_continues_after_a_kill(tmp_path, tracks):
    folder = tmp_path / "s"
    run(f"{NEW} {folder}")
    plan = (folder / "session.toml").read_text()
    assert 'on = "floor"' in plan
    assert "align its links" in run(f"calibrate status {folder}")
    first = run(f"calibrate {folder}", typed=f"\n{tracks[0]}\n{tracks[0]} cm\nquit\n")
    assert "behind the file's name at the prompt: one of m, cm, mm, in, ft, yd" in first
    assert "Push 1 of 8, straight, THERE" in first
    assert "reading 1, push there" in first
    # A second process finds all readings; the half line that a kill left does not count.
    with (folder / "readings.csv").open("a") as file:
        file.write("2,push,2026-")
    second = run(f"calibrate {folder}", typed=f"\n\n\n{tracks[1]} cm\nundo\n{tracks[1]} cm\nquit\n")
    assert "Push 2 of 8, straight, BACK" in second
    assert "1 push" in second
    taken = run(f"calibrate push {folder} {tracks[2]} {tracks[3]} --unit cm")
    assert taken.count("reading") == 2
    session = load_session(folder)
    assert [p.way for p in session.kept_pushes] == ["there", "back", "there", "back"]
    assert "already" in run(f"calibrate push {folder} {tracks[2]} --unit cm", fails=True)
    refusal = run(f"fit {folder}", fails=True)
    assert "cn and fn0 cannot be told" in refusal
    assert "bend of 42 degrees" in refusal


def test_a_treadmill_session_continues_on_the_floor(tmp_path):
    folder = tmp_path / "s"
    run(f"calibrate new {folder} --defaults --surface belt --mass-kg 0.454")
    replan(folder, on="floor")
    output = run(f"calibrate {folder}", typed="\n1.0\n2.4\n1.1 2.5\nundo\nquit\n")
    assert "kept as reading 1" in output
    assert "no fit yet: it needs readings of the straight and of the bent robot" in output
    assert output.count("no fit yet") == 1
    assert "pushes, straight 1 of 8, more to come" in run(f"calibrate status {folder}")
    output = run(f"calibrate {folder}", typed="\n\nskip\n1.0 2.4\nquit\n")
    assert "left out: push 2 of 8, straight" in output
    assert "Push 3 of 8, straight, BACK" in output
    run(f"calibrate {folder}", typed="\n\n" + 5 * "skip\n" + "quit\n")
    assert "pushes, straight 2 of 8, the rest left out" in run(f"calibrate status {folder}")


def test_a_simulated_person_uses_the_wheels_of_the_session(tmp_path):
    """Without the wheels' inertia, a sixth of the mass, dry friction would be 15 % too large."""
    folder, script = tmp_path / "s", tmp_path / "person.toml"
    run(f"{NEW} {folder}")
    settings = folder / "session.toml"
    settings.write_text(settings.read_text().replace('wheels_kg = ""', "wheels_kg = 0.1"))
    script.write_text("[simulated]\nseed = 1\nct = 0.084\ncn = 1.2\nft0 = 0.14\nfn0 = 0.27\n")
    run(f"calibrate {folder} --script {script}")
    fit = answer(f"fit {folder} --no-save")
    assert fit["parameters"]["ft0_whole"]["value"] == pytest.approx(0.14, rel=0.05)


def test_advice_and_report_of_a_floor(tmp_path):
    folder = tmp_path / "s"
    person = drawn_person(CASES[0], np.random.default_rng(5))
    setup = floor_setup(CASES[0])
    create_session(folder, replace(setup, provenance=replace(setup.provenance, source="the lab")))
    with Journal(folder) as journal:
        take_all(journal, person)
    advice = answer(f"advise {folder} --gait 70 75 0.5 --set samples=16")
    assert {reading["kind"] for reading in advice["readings"]} <= {"push", "film", "servo"}
    best = next(reading for reading in advice["readings"] if reading["kind"] == "push")
    assert best["band"] < advice["band"]
    assert 0 < best["minutes"] < 10
    page = tmp_path / "report.html"
    run(f"report {folder} --servo ideal --out {page}")
    text = page.read_text()
    assert "pushes: places over time with the law" in text
    assert f"{len(load_session(folder).kept_pushes)} pushes" in text
    assert "`" not in re.sub(r"<(style|svg).*?</\1>", "", text, flags=re.S)
    run(f"fit {folder} --plot {tmp_path}/fit.png")
    assert (tmp_path / "fit.png").stat().st_size > 10_000
