"""`fit` and the friction that it hands to other commands."""

import json
from functools import partial

import pytest
import serpenoid as sn
from command_line import answer, serpenoid
from robots import copy_of_2005

run = partial(serpenoid, check=True)
GAIT = "--alpha-deg 70 --beta-deg 75 --omega-rad-s 5"


@pytest.fixture
def folder(tmp_path):
    return copy_of_2005(tmp_path / "session")


def test_fit_shows_whole_and_per_link_values_and_keeps_them(folder):
    shown = run(f"fit --verbose {folder}").stdout
    assert "ct_whole" in shown
    assert "each of 6 links" in shown
    assert "0.084" in shown
    assert "0.014" in shown
    assert "chi2 without" in shown
    kept = sn.load_fit(folder)
    assert kept.parameters["ct_whole"].value == pytest.approx(0.084, rel=1e-4)
    assert answer(f"fit --no-save --method naive {folder}")["method"] == "naive"
    assert sn.load_fit(folder).method == "joint"


def test_a_session_or_its_fit_gives_friction_to_other_commands(folder):
    steady = f"steady {GAIT} --servo ideal"
    asked = answer(f"{steady} --robot {folder}")["speed_m_s"]
    # the speed that the paper's lines give, known to 1e-6
    assert asked == pytest.approx(0.133205, rel=1e-4)
    run(f"fit {folder}")
    file = folder / "fit.json"
    kept = file.read_text()
    file.write_text("{}")  # an older version's, or edited: the readings are there
    anew = run(f"{steady} --json --robot {folder}")
    assert json.loads(anew.stdout)["speed_m_s"] == pytest.approx(asked, rel=1e-9)
    assert "fitted anew" in anew.stderr
    file.write_text(kept)
    assert answer(f"{steady} --robot {file}")["speed_m_s"] == pytest.approx(asked, rel=1e-9)
    # fn0 of the whole snake, as fit prints it: the readings' own is 0.27 N
    assert answer(f"{steady} --set fn0=0.6 --robot {file}")["speed_m_s"] > 1.05 * asked
    assert answer(f"simulate {GAIT} --duration-s 0.1 --robot {folder}")


def test_compare_predicts_and_draws_what_is_not_measured_yet(folder, tmp_path):
    picture = tmp_path / "compare.svg"
    told = answer(f"compare {folder} --gait 70 75 1.0 --set samples=16 --plot {picture}")
    assert told["verdict"] == "not measured"
    assert told["gaits"][0]["exact_m_s"] == pytest.approx(0.152, rel=0.01)
    assert picture.read_text().startswith("<?xml")
    assert serpenoid(f"compare {folder}").returncode == 2


def test_drive_tells_the_speed_that_the_friction_predicts(folder):
    gait = "--alpha-deg 70 --beta-deg 75 --omega-rad-s 3"
    drive = f"drive {gait} --port virtual:fast --duration-s 1"
    fitted = f"{drive} --robot {folder}"
    driven = answer(fitted)
    assert driven["frame_ms"] == 20.0
    assert driven["predicted"]["servo"] == "hobby"
    told = run(fitted)
    assert told.stdout.startswith("predicted: 0.0")
    assert "predicted speed" in told.stdout
    assert "predicted" not in run(drive).stdout


def test_friction_of_a_robot_with_other_links_drives_nothing(folder):
    text = (folder / "session.toml").read_text()
    (folder / "session.toml").write_text(text.replace("links = 6", "links = 9"))
    driven = serpenoid(f"drive {GAIT} --port virtual:fast --robot {folder}")
    assert driven.returncode == 2
    assert "a robot of 9 links, but this board moves 6 links" in driven.stderr
    assert "--port virtual:joints=8" in driven.stderr
