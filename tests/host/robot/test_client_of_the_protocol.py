"""The client that firmware/PROTOCOL.md ends with: as short as it says, and it works."""

from __future__ import annotations

import ast
import subprocess
import sys
import textwrap
from pathlib import Path

from robot.fake_board import FakeBoard
from robot.patience import LONG_S

PROTOCOL = Path(__file__).resolve().parents[3] / "firmware" / "PROTOCOL.md"
ROUNDS = "range(10)"


def client() -> str:
    """Return the program in the document's last section."""
    _, _, section = PROTOCOL.read_text().partition("## A client in 40 lines\n")
    return textwrap.dedent(section[section.index("\n    ") :]).strip()


def run(board: FakeBoard, tmp_path: Path) -> subprocess.Popen[str]:
    program = tmp_path / "client.py"
    assert ROUNDS in client()
    program.write_text(client().replace(ROUNDS, "range(3)"))
    command = [sys.executable, str(program), board.port]
    return subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def test_it_has_forty_lines():
    assert len(client().splitlines()) <= 40


def test_it_drives_the_robot_and_stops_it(tmp_path):
    with FakeBoard() as board:
        out, err = run(board, tmp_path).communicate(timeout=LONG_S)
        assert board.await_state("hold"), err
    assert not err
    frames = [ast.literal_eval(line) for line in out.splitlines()]
    assert frames[-1]["st"] == "gait"
    assert abs(float(frames[-1]["j1"])) <= 30
    assert len({frame["t"] for frame in frames}) == len(frames) > 20


def test_it_stops_the_robot_however_it_ends(tmp_path):
    with FakeBoard() as board:
        child = run(board, tmp_path)
        assert board.await_state("gait")
        child.send_signal(2)
        _, err = child.communicate(timeout=LONG_S)
        assert board.await_state("hold")
    assert "KeyboardInterrupt" in err
