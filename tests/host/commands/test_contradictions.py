"""Options that contradict each other, do nothing or look like another unit are told, not obeyed."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from serpenoid.commands.main import cli
from serpenoid.commands.options import as_typed, make_robot
from serpenoid.model.errors import BadInput
from serpenoid.model.robot import Robot

SESSION = Path(__file__).parents[3] / "calibration_data" / "nirakh-2005"
GAIT = ["--alpha-deg", "30", "--beta-deg", "80", "--omega-rad-s", "5"]


def refusal(*args: str) -> str:
    """Run a command that must be refused; return what it says."""
    error = CliRunner().invoke(cli, args, standalone_mode=False).exception
    assert isinstance(error, (click.UsageError, BadInput)), repr(error)
    return str(error)


def warned(*args: str) -> str:
    """Run a command that must answer; return its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        done = CliRunner().invoke(cli, [*args, "--json"], standalone_mode=False)
    assert done.exception is None, repr(done.exception)
    return "\n".join(str(warning.message) for warning in caught)


@pytest.mark.parametrize("option", ["--stiffness-n-m", "--damping-n-s-m"])
def test_springs_of_pinned_joints(option: str) -> None:
    assert "no effect" in refusal("steady", *GAIT, option, "5")
    refused = refusal("steady", *GAIT, "--formulation", "implicit", option, "nan")
    assert refused.startswith(f"{option} is nan")


@pytest.mark.parametrize(
    ("span", "told"),
    [
        ("75:5:5", "must go upwards, such as 5:75:5"),
        ("5:75:-5", "must go upwards, such as 5:75:5"),
        ("5:75:0", "must go upwards, such as 5:75:1"),
        ("5:75", "is not FIRST:LAST:STEP"),
        ("5,75,5", "is not FIRST:LAST:STEP"),
        ("5:nan:5", "is not FIRST:LAST:STEP"),
        ("1:75:1e-6", "the most is 100000: take a larger step"),
    ],
)
def test_ranges(span: str, told: str) -> None:
    assert told in refusal("sweep", "--alpha-deg", span, "--json")


def test_what_varies_is_not_fixed(tmp_path: Path) -> None:
    out = ["--out", str(tmp_path / "study")]
    told = refusal("sweep", *out, "--links", "8", "--vary", "links=2:4:1")
    assert "--vary links and --links contradict each other" in told
    told = refusal("sweep", *out, "--vary", "ct=0:1:1", "--vary", "ct=2:3:1")
    assert "--vary ct and another one contradict" in told
    assert not (tmp_path / "study").exists()


def test_more_gaits_than_memory_holds(tmp_path: Path) -> None:
    many = ["--alpha-deg", "1:75:0.01", "--beta-deg", "1:90:0.01"]
    assert "--out STUDY" in refusal("sweep", *many, "--out", str(tmp_path / "a.csv"))
    few = ["--alpha-deg", "1:75:0.1", "--beta-deg", "1:90:0.1", "--omega-rad-s", "1:20:1"]
    assert "too many for JSON" in refusal("sweep", *few, "--json")


def test_a_scheduler_without_port(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    told = refusal("sweep", "--scheduler", "foo", "--out", str(tmp_path / "a.csv"))
    assert "must be an address with a port" in told


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        (["--alpha-deg", "0.52", "--beta-deg", "1.4", "--omega-rad-s", "5"], "29.79 and 80.21"),
        ([*GAIT[:4], "--omega-rad-s", "286.5"], "type 5"),
        ([*GAIT, "--length-m", "76"], "If mm were meant, type 0.076"),
        ([*GAIT, "--mass-kg", "75.6"], "If g were meant, type 0.0756"),
    ],
)
def test_another_unit_is_doubted(typed: list[str], meant: str) -> None:
    plain = ["--ft0", "0", "--fn0", "0", "--servo", "ideal"]
    assert meant in warned("steady", *plain, *typed)


def test_nothing_is_doubted_of_the_presets() -> None:
    assert "were meant" not in warned("steady", "--robot", "paper", *GAIT, "--servo", "ideal")


def test_an_accuracy_that_springs_do_not_reach_is_told() -> None:
    """Dry ground by time steps: its error is that of the steps, whatever was asked for."""
    told = warned("steady", *GAIT, "--formulation", "implicit")
    assert "not to the --rtol of 1e-06" in told


def test_degrees_come_back_as_typed() -> None:
    asked = ["--robot", "paper", *GAIT, "--json"]
    done = CliRunner().invoke(cli, ["steady", *asked, "--servo", "ideal"])
    assert json.loads(done.stdout)["gait"]["alpha_deg"] == 30.0
    done = CliRunner().invoke(cli, ["sweep", *asked])
    assert json.loads(done.stdout)["alpha_deg"] == [30.0]


def test_arguments_in_a_message_keep_their_names() -> None:
    options = {"omega_rad_s": "--omega-rad-s"}
    told = as_typed("no state for Gait(omega_rad_s=1.0): omega_rad_s is 1", options)
    assert told == "no state for Gait(omega_rad_s=1.0): --omega-rad-s is 1"


@pytest.mark.parametrize("command", ["compare", "advise"])
@pytest.mark.parametrize(
    ("gait", "told"),
    [
        (("270", "75", "1"), "--gait ALPHA_DEG is 270.0; it must be a finite number, at least 0"),
        (("70", "nan", "1"), "--gait BETA_DEG is nan"),
        (("70", "75", "-1"), "--gait HZ is -1.0"),
    ],
)
def test_listed_gaits(command: str, gait: tuple[str, ...], told: str) -> None:
    assert told in refusal(command, str(SESSION), "--gait", *gait)


def test_a_mass_in_grams_is_doubted_when_it_is_amended(tmp_path: Path) -> None:
    folder = str(tmp_path / "mine")
    assert CliRunner().invoke(cli, ["calibrate", "new", folder, "--defaults"]).exit_code == 0
    with pytest.warns(UserWarning, match="the mass-kg now: 80 kg for one link"):
        done = CliRunner().invoke(cli, ["calibrate", "amend", folder, "robot.mass_kg=480"])
    assert done.exit_code == 0


def test_a_uniform_rod_of_another_length_stays_one() -> None:
    given = dict.fromkeys(option.name for option in cli.commands["steady"].params)
    robot, _ = make_robot(given | {"link_length_m": 0.2, "preset": "paper"})
    assert robot == Robot(6, 1.0, 0.2)
    robot, _ = make_robot(
        given | {"link_length_m": 0.2, "link_inertia_kg_m2": 0.01, "preset": "paper"}
    )
    assert robot == Robot(6, 1.0, 0.2, 0.01)
