"""The commands optimize and figures: answers, limits, fronts, warnings, the board, the page."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from serpenoid.commands.main import cli
from serpenoid.gaits import paper_study


def run(*words: str, code: int = 0):
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == code, result.output
    return result


def test_optimum_with_its_error_and_margins() -> None:
    found = json.loads(run("optimize", "--robot", "paper", "--speed", "0.1", "--json").output)
    assert found["gait"]["alpha_deg"] == pytest.approx(31.77, abs=0.05)
    assert found["cost_w"] == pytest.approx(7.63769e-3, rel=2e-5)
    assert 0 < found["cost_error_w"] < 1e-6
    assert found["abs_power_w"] > found["power_w"]
    assert found["margins"]["near_cliff"] is False
    assert found["margins"]["amplitude"] > 0.05


def test_limits_in_degrees_are_kept_and_told() -> None:
    words = run("optimize", "--robot", "paper", "--speed", "0.5", "--servo-speed-deg-s", "229")
    assert "servo speed" in words.output
    words = run("optimize", "--robot", "paper", "--speed", "9", "--omega-high-rad-s", "6", code=1)
    assert "the fastest found makes 0.47" in str(words.exception)


def test_several_speeds_are_a_front() -> None:
    found = json.loads(
        run("optimize", "--robot", "paper", "--speed-m-s", "0.1,0.5", "--json").output
    )
    assert [best["cost_w"] for best in found["front"]] == pytest.approx(
        [7.63769e-3, 0.22733], rel=2e-5
    )
    run("optimize", "--robot", "paper", "--speed", "0.1,0.2", "--robust", code=2)
    run("optimize", "--robot", "paper", "--speed", "fast", code=2)


def test_robust_says_what_it_costs_and_what_it_keeps() -> None:
    found = json.loads(
        run("optimize", "--robot", "paper", "--speed", "0.2", "--robust", "--amplitude-sigma",
            "0.05", "--json").output
    )  # fmt: skip
    assert found["low_speed_m_s"] >= 0.179
    assert found["premium"] > 0
    assert "amplitude ± 3 % common and ± 5 % of each joint" in found["uncertainty"]


def test_steady_warns_at_a_cliff() -> None:
    words = ["steady", "--alpha-deg", "66.7", "--beta-deg", "78.8", "--omega-rad-s", "1.6"]
    assert "stands at a cliff" in run(*words).stderr
    assert json.loads(run(*words, "--json").stdout)["margins"]["near_cliff"] is True


def test_the_cliff_is_drawn_with_its_data(tmp_path: Path) -> None:
    picture = tmp_path / "cliff.png"
    run("optimize", "--robot", "paper", "--speed", "0.1", "--plot", str(picture))
    assert picture.read_bytes()[:4] == b"\x89PNG"
    rows = picture.with_suffix(".csv").read_text().splitlines()
    assert rows[0] == "amplitude_factor,cn_factor,speed_m_s"
    assert len(rows) == 1 + 17 * 17


def test_a_gait_goes_to_the_board() -> None:
    words = run("optimize", "--robot", "paper", "--speed", "0.1", "--send", "--port", "virtual",
                "--duration-s", "0.5", "--json")  # fmt: skip
    decoder = json.JSONDecoder()
    first, end = decoder.raw_decode(words.stdout)
    second, _ = decoder.raw_decode(words.stdout[end:].lstrip())
    assert second["frames"] > 5
    assert second["gait"]["alpha_deg"] == pytest.approx(first["gait"]["alpha_deg"])


def test_claims_hang_on_the_reading() -> None:
    gait = paper_study.PATH_GAIT
    joints = paper_study.shown_amplitude_deg(gait, paper_study.Reading())
    links = paper_study.shown_amplitude_deg(gait, paper_study.Reading(angles="absolute"))
    assert joints == pytest.approx(30)
    assert links == pytest.approx(23.34, abs=0.01)  # 30 deg / (2 sin 40 deg)
    assert 0.05 < paper_study.along_x(gait) < 0.99


def test_springs_errors_are_the_papers_for_angles_and_not_for_torques() -> None:
    found = paper_study.compare_formulations()
    assert 5e-4 < abs(found.theta_error_rad).max() < 2e-3
    assert paper_study.compare_torque_driven() > 0.1


@pytest.mark.slow
def test_the_whole_study(tmp_path: Path) -> None:
    found = json.loads(run("figures", "--out", str(tmp_path), "--json").stdout)
    verdicts = {c["where"]: c["verdict"] for c in found["claims"]}
    assert verdicts["Fig. 6"] == verdicts["Fig. 8"] == verdicts["Fig. 9"] == "agrees"
    assert verdicts["Fig. 10"] == verdicts["the search"] == "differs"
    page = (tmp_path / "index.html").read_text()
    for name in ("fig6-7", "fig8", "fig9-11", "fig12-13", "fig15-16", "fig17", "cliff-fragile"):
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
        assert f"{name}.png" in page
