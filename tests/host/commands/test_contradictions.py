"""Options that contradict each other, do nothing or look like another unit are told, not obeyed."""

from __future__ import annotations

from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from robots import NIRAKH_2005
from serpenoid import BadInput
from serpenoid.commands.main import cli

SHAPE = "--alpha-deg 30 --beta-deg 80"
GAIT = f"{SHAPE} --omega-rad-s 5"


def refusal(line: str) -> str:
    """Run a command that must be refused; return what it says."""
    error = CliRunner().invoke(cli, line, standalone_mode=False).exception
    assert isinstance(error, (click.UsageError, BadInput)), repr(error)
    return str(error)


@pytest.mark.parametrize(
    ("span", "told"),
    [
        ("75:5:5", "goes upwards"),
        ("5:75", "FIRST:LAST:STEP"),
        ("1:75:1e-7", "at most 1e+06 steps"),
    ],
)
def test_ranges(span: str, told: str) -> None:
    assert told in refusal(f"sweep --alpha-deg {span} --json")


def test_more_gaits_than_memory_holds(tmp_path: Path) -> None:
    out = f"--out {tmp_path / 'a.csv'}"
    many = "--alpha-deg 1:75:0.1 --beta-deg 1:90:0.1 --omega-rad-s 1:20:1"
    assert "are too many for one answer" in refusal(f"sweep {many} {out}")


def test_a_scheduler_without_port(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    told = refusal(f"sweep --scheduler foo --out {tmp_path / 'a.csv'}")
    assert "must be an address with a port" in told


@pytest.mark.parametrize("command", ["compare", "advise"])
@pytest.mark.parametrize(
    ("gait", "told"),
    [
        ("270 75 1", "alpha_deg is 270.0; it must be a finite number, at least 0"),
        ("70 nan 1", "beta_deg is nan"),
        ("70 75 -1", "hertz is -1.0"),
    ],
)
def test_listed_gaits(command: str, gait: str, told: str) -> None:
    assert told in refusal(f"{command} {NIRAKH_2005} --gait {gait}")
