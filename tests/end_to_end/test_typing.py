"""A user's script is clean under pyright strict and mypy strict."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = '''
"""What a user writes first."""
from pathlib import Path

import serpenoid as sn
from serpenoid.robot import RobotBoard as Board

robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
gait = sn.Gait(alpha_rad=1.2, beta_rad=1.3, omega_rad_s=5.0)
speed: float = sn.steady_gait(robot, ground, gait).speed_m_s
run = sn.simulate(sn.Scene(robot, ground, gait, duration_s=1.0))
run.to_csv(Path("run.csv"))
last: float = float(run.x_m[-1].mean())
grid = sn.sweep(robot, ground, alpha_rad=[0.5], beta_rad=[1.4], omega_rad_s=[5.0])
best: float = float(grid.speed_m_s.max())
cheap: sn.Gait = sn.least_power_gait(robot, ground, speed_m_s=0.1).gait
fit: sn.FrictionFit = sn.fit_friction(sn.load_session(Path("session")))
print(speed, last, best, cheap, fit.ground, sn.__version__)
with Board("virtual") as board:
    board.gait(gait)
    for frame in board.frames(duration_s=1.0):
        print(frame.frame, frame.setpoint_rad)
'''


@pytest.fixture
def script(tmp_path) -> Path:
    path = tmp_path / "script.py"
    path.write_text(SCRIPT)
    (tmp_path / "pyrightconfig.json").write_text(json.dumps({"typeCheckingMode": "strict"}))
    return path


def test_pyright_strict(script) -> None:
    done = subprocess.run(
        [
            Path(sys.executable).with_name("pyright"),
            "--pythonpath",
            sys.executable,
            "-p",
            str(script.parent),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "1 file" in done.stdout or "0 errors" in done.stdout


@pytest.mark.slow
def test_mypy_strict(script) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--python-executable", sys.executable, script],
        cwd=script.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
