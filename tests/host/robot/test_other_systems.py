"""Commands run on a system without fcntl, termios, grp and process groups, such as Windows."""

from __future__ import annotations

import subprocess
import sys

import pytest
import serpenoid as sn

HIDE_MODULES = """
import builtins, os, sys

original_import = builtins.__import__

def import_visible(name, scope=None, *args, **kwargs):
    is_ours = str((scope or {}).get("__name__", "")).startswith("serpenoid")
    if is_ours and name in ("fcntl", "termios", "grp"):
        raise ImportError(name)
    return original_import(name, scope, *args, **kwargs)

builtins.__import__ = import_visible
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
def run_portably(tmp_path):
    """Return a function that runs a command without these modules and returns its output."""

    def run_command(command: str, program: str = COMMAND) -> str:
        python = [sys.executable, "-c", HIDE_MODULES + program, *command.split()]
        result = subprocess.run(
            python, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
        )
        assert result.returncode == 0, result.stderr
        return result.stdout

    return run_command


def test_a_board_is_driven_and_examined(run_portably):
    assert "frames" in run_portably(DRIVE)
    assert "clean, over" in run_portably("doctor --port virtual:fast --listen-s 0.5")


def test_a_session_is_taken(run_portably, tmp_path):
    run_portably("calibrate new s --defaults --simulated --surface belt")
    (tmp_path / "plan.toml").write_text(PLAN)
    assert "stations" in run_portably("calibrate s --script plan.toml")
    assert len(sn.load_session(tmp_path / "s").kept_stations) > 12


def test_every_module_is_there(run_portably):
    run_portably("", IMPORTS)
