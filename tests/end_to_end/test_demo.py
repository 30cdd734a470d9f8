"""The README's first command: everything it writes is there and says what it should."""

from __future__ import annotations

import json
import subprocess

import pytest
from command_line import program, serpenoid
from refusals import refused
from serpenoid import load_session
from serpenoid.commands.demo import take_session
from serpenoid.taking.new_session import create_session, default_setup


@pytest.mark.slow
def test_demo(tmp_path) -> None:
    out = tmp_path / "demo"
    done = subprocess.run(program(f"demo --out {out}"), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) <= 15
    assert [line[:5] for line in lines if line.startswith("[")] == [f"[{k}/5]" for k in range(1, 6)]
    assert lines[-1].startswith(f"Look at {out}/report.html")
    for name in ("comparison.png", "film.png", "floor.png"):
        assert (out / name).read_bytes()[:4] == b"\x89PNG"
    found = json.loads((out / "demo.json").read_text())
    for fit in (found["fit"], found["floor"]):
        for name, truth in found["truth"].items():
            low, high = next(
                p["interval"] for n, p in fit["parameters"].items() if n.startswith(name)
            )
            # An interval of 95 % of one seeded session: so wide at least, by a half.
            assert low - 0.5 * (high - low) < truth < high + 0.5 * (high - low)
    assert len(load_session(out / "floor").kept_pushes) == 6
    assert found["comparison"]["verdict"] == "agrees"
    wanted = found["wanted"]
    assert 0.04 < wanted["low_m_s"] < wanted["crawls_m_s"] < wanted["high_m_s"] < 0.11
    assert "</html>" in (out / "report.html").read_text()
    assert len(load_session(out / "session").kept) > 12
    film = found["film"]
    assert abs(film["speed_m_s"] - film["truth"]["speed_m_s"]) < 4 * film["speed_sigma_m_s"]


def test_another_session_is_not_taken_for_the_demos(tmp_path) -> None:
    create_session(tmp_path / "session", default_setup("mine"))
    with refused("not the demo's"):
        take_session(tmp_path / "session")


def test_demo_into_a_file_is_refused(tmp_path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    done = serpenoid(f"demo --out {blocked}")
    assert done.returncode == 2
    assert "is a file" in done.stderr
