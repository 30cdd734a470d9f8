"""The commands optimize, steady and figures: answers, limits, warnings, refusals."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
import serpenoid as sn
from command_line import answer, serpenoid

OPTIMIZE = "optimize --robot paper --speed"
IDEAL = f"{OPTIMIZE} 0.1 --servo ideal"  # joints that follow the gait


def test_the_papers_optimum_with_its_error_and_losses() -> None:
    result = answer(f"{IDEAL} --ideal")
    assert result["gait"]["alpha_deg"] == pytest.approx(31.77, abs=0.05)
    assert result["cost_w"] == pytest.approx(7.63769e-3, rel=2e-5)
    assert 0 < result["cost_error_w"] < 1e-6
    assert result["abs_power_w"] > result["positive_power_w"] > result["power_w"]
    assert 0 < result["losses"]["friction"] < 0.1
    assert result["ideal"] is None


def test_the_answer_has_a_drivable_gait_and_the_papers_optimum() -> None:
    """Servos can follow the gait, joints stay within 90 degrees, and losses are at most 20 %."""
    result = answer("optimize --speed 0.1")
    assert result["servo"]["follows"] is True
    assert result["gait"]["alpha_deg"] <= 90
    assert max(result["losses"].values()) == pytest.approx(0.2, abs=2e-3)
    paper = result["ideal"]
    assert paper["cost_w"] < result["cost_w"]
    assert max(paper["losses"].values()) > 0.3


def test_the_servo_limits_the_rate() -> None:
    """At 0.15 m/s the joints of the best gait would be too fast for hobby servos."""
    words = " ".join(serpenoid("optimize --speed 0.15", check=True).stdout.split())
    assert "Limited by servo speed" in words
    assert "The paper's optimum, " in words


def test_limits_in_degrees_are_kept_and_named() -> None:
    limited = serpenoid(f"{OPTIMIZE} 0.5 --set servo_speed_deg_s=229 --servo ideal", check=True)
    assert "servo speed" in limited.stdout
    refused = serpenoid(f"{OPTIMIZE} 9 --set omega_high_rad_s=6").stderr
    assert "makes 0.4" in refused


def test_two_periodic_motions_are_named() -> None:
    """On viscous ground that brakes and grips little; runs over thousands of cycles have both."""
    body = "links=4 mass_kg=0.2995066 link_length_m=0.0987888 offset_deg=-18.949213"
    ground = "ct=0.005218119 cn=0.00032280766 ft0=0 fn0=0"
    gait = "--alpha-deg 58.648886 --beta-deg 101.254553 --omega-rad-s 1.275745 --servo ideal"
    typed = " ".join(f"--set {one}" for one in f"{body} {ground}".split())
    told = serpenoid(f"steady {gait} {typed}", check=True).stderr
    assert "the other turns -1.36 deg and goes 0.0403 m a cycle; from rest the robot ends" in told


def test_steady_warns_at_a_sharp_drop_of_speed() -> None:
    line = "steady --alpha-deg 66.7 --beta-deg 78.8 --omega-rad-s 1.6 --servo ideal"
    assert "stands at a sharp drop of speed" in serpenoid(line, check=True).stderr
    assert answer(line)["losses"]["amplitude"] == pytest.approx(0.44, abs=0.02)


def test_the_gait_can_be_typed_into_drive() -> None:
    line = serpenoid(f"{IDEAL} --ideal", check=True).stdout.splitlines()[-1]
    typed = line.removeprefix("drive it: serpenoid ")
    driven = answer(f"{typed} --port virtual:fast --duration-s 1")
    assert driven["gait"]["alpha_deg"] == pytest.approx(31.77, abs=0.05)


@pytest.mark.parametrize("speed", ["1e6", "1e-8"])
def test_an_impossible_speed_is_refused_at_once(speed: str) -> None:
    """A search would take minutes at higher and higher rates, or be lost in rounding errors."""
    refused = serpenoid(f"optimize --speed {speed}")
    assert refused.returncode == 2
    assert "at most 45.6" in refused.stderr


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ("--set links=2", "no gait travels at all"),
        ("--set joint_angle_deg=1.2 --set omega_high_rad_s=20", "(joint angle 1.2 deg"),
        ("--set servo_torque_nm=1e-5", "more torque"),
        ("--set servo_speed_deg_s=10", "servo speed 10 deg/s"),
    ],
)
def test_the_reason_why_there_is_no_gait(limits: str, message: str) -> None:
    assert message in serpenoid(f"{OPTIMIZE} 0.1 {limits}").stderr


@pytest.mark.slow
def test_the_whole_study(tmp_path: Path) -> None:
    serpenoid(f"figures --out {tmp_path}", check=True)
    result = json.loads((tmp_path / "claims.json").read_text())
    verdicts = {c["where"]: c["verdict"] for c in result["claims"]}
    assert verdicts["Fig. 6"] == verdicts["Fig. 8"] == verdicts["Fig. 9"] == "agrees"
    assert verdicts["Fig. 10"] == "in part"  # near 80 deg at some of the speeds
    assert verdicts["the search"] == "differs"
    for name in (
        "fig6-7",
        "fig8",
        "fig9-11",
        "fig12-13",
        "fig15-16",
        "fig17",
        "front-2005",
    ):
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000


def test_an_ideal_gait_that_is_too_fast_for_servos_has_a_warning() -> None:
    viscous = "optimize --set ft0=0 --set fn0=0 --servo ideal --ideal --speed"
    assert "Too fast for a typical hobby servo" in serpenoid(f"{viscous} 10", check=True).stderr
    assert "Too fast" not in serpenoid(f"{viscous} 0.1", check=True).stderr


def test_a_stale_fit_is_named_once(tmp_path: Path) -> None:
    of_2005 = Path(__file__).parents[3] / "calibration_data" / "nirakh-2005"
    for name in ("session.toml", "readings.csv", "events.csv"):
        shutil.copy(of_2005 / name, tmp_path)
    fit = sn.save_fit(sn.fit_friction(sn.load_session(tmp_path)), tmp_path)
    with (tmp_path / "events.csv").open("a") as file:
        file.write(",void,11,slipped\n")
    line = f"optimize --robot {fit} --set ft0=0 --set fn0=0 --speed 0.1 --servo ideal"
    done = serpenoid(line, check=True)
    assert done.stderr.count("is older than the readings") == 1
