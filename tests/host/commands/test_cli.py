"""The command line as a user meets it: answers, refusals, exit status, no traceback."""

from __future__ import annotations

import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from command_line import answer, program, serpenoid
from robot.patience import LONG_S
from serpenoid.commands.main import cli

PAPER = "--robot paper --alpha-deg 30 --beta-deg 80"
SHAPE = "--alpha-deg 70 --beta-deg 75"
GAIT = f"{SHAPE} --omega-rad-s 5"
SLOW = f"{SHAPE} --omega-rad-s 3"  # No servo is too slow for it.
IDEAL = "--servo ideal"


def test_steady() -> None:
    got = answer(f"steady {GAIT} {IDEAL}")
    assert got["speed_m_s"] == pytest.approx(0.133205, rel=2e-4)
    assert got["error_estimate"] < 1e-6
    assert "m/s" in serpenoid(f"steady {GAIT} {IDEAL}").stdout
    same = answer(f"steady {SHAPE} {IDEAL} --frequency-hz {5 / (2 * math.pi)}")
    assert same["speed_m_s"] == pytest.approx(got["speed_m_s"], rel=1e-6)


TELLING = """
from serpenoid import _core
from serpenoid.commands.main import main
run = _core.run
def told(*arguments):
    print("in the core", flush=True)
    return run(*arguments)
_core.run = told
main()
"""


def test_ctrl_c_stops_a_long_run_at_once() -> None:
    args = f"simulate {GAIT} --robot paper --duration-s 1e7 --set record_every=1000".split()
    run = subprocess.Popen(
        [sys.executable, "-c", TELLING, *args],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert run.stdout is not None
        assert run.stdout.readline() == "in the core\n"
        time.sleep(0.2)  # and would stay there for hours
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=LONG_S)
    finally:
        run.kill()
    assert run.returncode == 130
    assert said.split("\n") == ["nothing of this run is kept", "", "stopped", ""]


INTERRUPTED_IMPORT = """
from serpenoid import _core
from serpenoid.__main__ import main
def initialized(*_):
    raise ImportError("initialization failed") from KeyboardInterrupt()
_core.run = initialized
main()
"""


def test_ctrl_c_while_a_module_is_imported_is_no_traceback() -> None:
    line = [sys.executable, "-c", INTERRUPTED_IMPORT, *f"simulate {GAIT}".split()]
    run = subprocess.run(line, capture_output=True, text=True, timeout=LONG_S, check=False)
    assert (run.returncode, run.stderr.strip()) == (130, "stopped")


@pytest.mark.parametrize(
    ("line", "status", "said"),
    [
        (f"steady {GAIT} --set links=1", 2, "links is 1"),
        (f"steady {SHAPE} --omega-rad-s nan", 2, "omega_rad_s is nan"),
        (f"steady {SHAPE} --omega-rad-s 0", 2, "omega_rad_s is 0.0"),
        (f"steady {GAIT} --alhpa-deg 3", 2, "No such option"),
        (f"steady {GAIT} --set ct=0 --set cn=0 --set ft0=0 --set fn0=0", 2, "no friction"),
        (f"simulate {GAIT} --set record_every=0", 2, "record_every is 0"),
        ("optimize --speed-m-s nan", 2, "speed_m_s is nan"),
        ("fit no-such-folder", 2, "no-such-folder"),
        ("report no-such-folder", 2, "calibrate new no-such-folder"),
        ("view no-such-file", 2, "'no-such-file' does not exist"),
        ("sweep --json --alpha-deg -3", 2, "alpha_deg is -3.0; it must be a finite"),
        (f"steady {SHAPE} --frequency-hz -1", 2, "hertz is -1.0"),
        ("steady --alpha-deg 1,5", 2, "not a valid float"),
        ("steady --set links=2.5", 2, "links is 2.5; it must be a whole number"),
        (f"steady {GAIT} --robot {300 * 'x'}.json", 1, "file name too long"),
        ("video tags --tag-mm nan", 2, "tag_mm is nan"),
        (f"drive {SHAPE} --omega-rad-s 60 {IDEAL} --port virtual:fast", 1, "omega=60"),
        (f"steady {GAIT} --robot nowhere.json", 2, "no such file"),
        (f"steady {GAIT} --robot nowhere", 2, "it must be 2005, paper, a session's folder"),
    ],
)
def test_refusals(line: str, status: int, said: str) -> None:
    done = serpenoid(line)
    assert done.returncode == status
    assert said in done.stderr
    assert done.stderr.startswith("serpenoid: ")
    assert done.stderr.count("\n") == 1  # one line, without a traceback


def every_option(command: click.Command = cli) -> Iterator[click.Parameter]:
    yield from command.params
    for inner in getattr(command, "commands", {}).values():
        yield from every_option(inner)


def test_there_are_few_options_and_names_to_set() -> None:
    options = [p for p in every_option() if isinstance(p, click.Option)]
    options = [p for p in options if p.name not in ("as_json", "version")]
    assert len(options) <= 150
    names = {name for p in options for name in getattr(p.type, "known", ())}
    assert 30 < len(names) <= 60


def test_names_to_set_are_listed_with_their_limits() -> None:
    told = " ".join(serpenoid("steady --set help", check=True).stdout.split())
    assert "mass_kg mass of the whole robot, as it crawls; kg; more than 0; default: 0.4536" in told
    assert "did you mean 'mass_kg'" in serpenoid(f"steady {GAIT} --set mas_kg=1").stderr
    assert "not of the form NAME=VALUE" in serpenoid(f"steady {GAIT} --set mass_kg").stderr


def test_mass_and_friction_are_the_whole_robots() -> None:
    """The numbers that README and `fit` print give the answer of the robot that they are of."""
    whole = "mass_kg=0.4536 link_length_m=0.076 ct=0.084 cn=1.2 ft0=0.14 fn0=0.27"
    typed = " ".join(f"--set {one}" for one in whole.split())
    pasted = answer(f"steady {GAIT} {IDEAL} --robot paper {typed}")
    of_2005 = answer(f"steady {GAIT} {IDEAL}")
    for name in ("speed_m_s", "power_w"):
        assert pasted[name] == pytest.approx(of_2005[name], rel=1e-9)


def test_a_number_in_another_unit_is_remarked_once() -> None:
    line = f"steady --sensitivities {GAIT} {IDEAL} --set link_length_m=7.6 --set mass_kg=453.6"
    remarks = serpenoid(line, check=True).stderr.strip().split("\n")
    assert [remark.partition(",")[0] for remark in remarks] == [
        "serpenoid: warning: a link is 7.6 m long",
        "serpenoid: warning: a link has 75.6 kg",
    ]


def test_help_has_a_part_for_researchers() -> None:
    builders, _, researchers = serpenoid("steady --help").stdout.partition("For researchers:")
    assert "--servo" in builders
    assert "--formulation" in researchers


def test_a_terminal_without_our_letters_gets_question_marks() -> None:
    asked = f"optimize --robot paper --speed-m-s 0.1 {IDEAL}"
    done = subprocess.run(
        program(asked),
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
    )
    assert "32?/84? at 0.29 Hz" in done.stdout


def test_help_tells_every_command_in_full() -> None:
    told = serpenoid("--help").stdout
    assert set(re.findall(r"^  ([a-z]+)  ", told, re.MULTILINE)) == set(cli.commands)
    assert "..." not in told.partition("See it work")[2]
    assert "(equations 58 to 62)" in " ".join(told.split())


def test_help_imports_nothing_slow() -> None:
    code = (
        "import sys, serpenoid.commands.main; "
        "print([m for m in ('numpy', 'scipy', 'matplotlib', 'rich', 'serial', "
        "'serpenoid.robot.robot') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_run_that_fails_leaves_one_line() -> None:
    """What lives on in its traceback at exit is no news to whoever reads the error."""
    done = serpenoid(f"drive {SLOW} --port virtual --duration-s 1 --record /dev/full")
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert "No space left" in line
