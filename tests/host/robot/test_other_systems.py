"""What runs where a system has no fcntl, termios, grp and process groups, as Windows has none."""

from __future__ import annotations

import subprocess
import sys

import pytest
import serpenoid as sn

HIDING = """
import builtins, os, sys

usual = builtins.__import__

def without(name, scope=None, *rest, **named):
    ours = str((scope or {}).get("__name__", "")).startswith("serpenoid")
    if ours and name in ("fcntl", "termios", "grp"):
        raise ImportError(name)
    return usual(name, scope, *rest, **named)

builtins.__import__ = without
del os.killpg
"""
COMMAND = """
from serpenoid.commands.main import main
main()
"""
IMPORTS = """
import contextlib, importlib, pkgutil, serpenoid

for module in pkgutil.walk_packages(serpenoid.__path__, "serpenoid."):
    with contextlib.suppress(ModuleNotFoundError):  # of an optional package
        importlib.import_module(module.name)
"""
DRIVE = "drive --port virtual --alpha-deg 30 --beta-deg 80 --omega-rad-s 3 --duration-s 0.5"
PLAN = "[simulated]\nseed = 3\nct = 0.084\ncn = 1.2\nft0 = 0.14\nfn0 = 0.27\n"


@pytest.fixture
def hidden(tmp_path):
    """Return a function that runs a command without these modules, and gives what it said."""

    def run(command: str, program: str = COMMAND) -> str:
        python = [sys.executable, "-c", HIDING + program, *command.split()]
        done = subprocess.run(
            python, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def test_a_board_is_driven_and_examined(hidden):
    assert "frames" in hidden(DRIVE)
    assert "clean, over" in hidden("doctor --port virtual:fast --listen-s 0.5")


def test_a_session_is_taken(hidden, tmp_path):
    hidden("calibrate new s --defaults --simulated --surface belt")
    (tmp_path / "plan.toml").write_text(PLAN)
    assert "stations" in hidden("calibrate s --script plan.toml")
    assert len(sn.load_session(tmp_path / "s").kept_stations) > 12


def test_every_module_is_there(hidden):
    hidden("", IMPORTS)
