"""The README's first command: everything it writes is there and says what it should."""

from __future__ import annotations

import re
import subprocess

import pytest
from command_line import program
from refusals import refused
from serpenoid import load_fit, load_session
from serpenoid.commands.demo import FRICTIONS, take_session
from serpenoid.taking.new_session import create_session, default_setup


@pytest.mark.slow
def test_demo(tmp_path) -> None:
    demo_folder = tmp_path / "demo"
    done = subprocess.run(
        program(f"demo --out {demo_folder}"), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) <= 15
    assert [line[:5] for line in lines if line.startswith("[")] == [f"[{k}/5]" for k in range(1, 6)]
    assert lines[-1].startswith(f"Look at {demo_folder}/report.html")
    for name in ("comparison.png", "film.png", "floor.png"):
        assert (demo_folder / name).read_bytes()[:4] == b"\x89PNG"
    for folder in ("session", "floor"):
        for row, truth in zip(
            load_fit(demo_folder / folder).rows(), FRICTIONS.values(), strict=True
        ):
            # An interval of 95 % of one seeded session: so wide at least, by a half.
            slack = 0.5 * (row.high - row.low)
            assert row.low - slack < truth < row.high + slack
    assert len(load_session(demo_folder / "floor").kept_pushes) == 6
    assert len(load_session(demo_folder / "session").kept_stations) > 12
    text = " ".join(done.stdout.split())
    assert "Both agree." in text
    film = re.search(r"crawls at (\S+) ± (\S+) mm/s \(truth (\S+)\)", text)
    assert film is not None
    speed, sigma, truth = map(float, film.groups())
    assert abs(speed - truth) < 4 * sigma
    speeds = re.search(r" m/s, (\S+) to (\S+) \(95 %.*crawls at (\S+)\. Look", text)
    assert speeds is not None
    low, high, crawls = map(float, speeds.groups())
    assert 0.04 < low < crawls < high < 0.11
    assert "</html>" in (demo_folder / "report.html").read_text()


def test_another_session_is_not_taken_for_the_demos(tmp_path) -> None:
    create_session(tmp_path / "session", default_setup("mine"))
    with refused("not the demo's"):
        take_session(tmp_path / "session")
