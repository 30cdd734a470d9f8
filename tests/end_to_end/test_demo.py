"""The README's first command: everything it writes is there and says what it should."""

from __future__ import annotations

import json
import subprocess

import pytest
from command_line import program, serpenoid
from serpenoid import load_session


@pytest.mark.slow
def test_demo(tmp_path) -> None:
    out = tmp_path / "demo"
    done = subprocess.run(program(f"demo --out {out}"), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) <= 28
    assert [line[:5] for line in lines if line.startswith("[")] == [f"[{k}/8]" for k in range(1, 9)]
    for name in (
        "friction.png",
        "speed.png",
        "path.png",
        "comparison.png",
        "film.png",
        "floor.png",
    ):
        assert (out / name).read_bytes()[:4] == b"\x89PNG"
    found = json.loads((out / "demo.json").read_text())
    values = {n.removesuffix("_whole"): p["value"] for n, p in found["fit"]["parameters"].items()}
    assert values == pytest.approx({"ct": 0.084, "cn": 1.2, "ft0": 0.14, "fn0": 0.27}, rel=1e-5)
    points = found["speed_against_frequency"]
    assert len(points) == 10
    for point in points:
        # a spring of k = 1000 N/m under this light robot: a few per cent
        assert point["implicit_m_s"] == pytest.approx(point["explicit_m_s"], rel=0.03)
        assert point["low_ideal_m_s"] < point["explicit_m_s"] < point["high_ideal_m_s"]
        too_fast = point["frequency_hz"] > point["highest_hz"]
        assert (point["low_m_s"] is None) == too_fast
    loop = json.loads((out / "loop.json").read_text())
    for fit in (loop["fit"], found["floor"]["fit"]):
        for name, truth in loop["truth"].items():
            low, high = next(
                p["interval"] for n, p in fit["parameters"].items() if n.startswith(name)
            )
            # An interval of 95 % of one seeded session: so wide at least, by a half.
            assert low - 0.5 * (high - low) < truth < high + 0.5 * (high - low)
    assert len(load_session(out / "floor").kept_pushes) == 6
    assert loop["comparison"]["verdict"] == "agrees"
    assert loop["advice"]["readings"]
    wanted = loop["wanted"]
    assert 0.04 < wanted["low_m_s"] < wanted["crawls_m_s"] < wanted["high_m_s"] < 0.11
    assert "</html>" in (out / "report.html").read_text()
    assert len(load_session(out / "session").kept) > 12
    film = found["film"]
    assert abs(film["speed_m_s"] - film["truth"]["speed_m_s"]) < 4 * film["speed_sigma_m_s"]
    assert found["path_gait"]["speed_m_s"] == pytest.approx(0.292060796024, rel=1e-6)


def test_demo_into_a_file_is_refused(tmp_path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    done = serpenoid(f"demo --out {blocked}")
    assert done.returncode == 2
    assert "is a file" in done.stderr
