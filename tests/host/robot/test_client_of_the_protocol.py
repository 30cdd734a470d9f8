"""The client that firmware/PROTOCOL.md ends with: as short as it says, and it works."""

from __future__ import annotations

import ast
import subprocess
import sys
import textwrap
from pathlib import Path
from subprocess import PIPE

import pytest
from robot.fake_board import FakeBoard
from robot.patience import LONG_S

PROTOCOL = Path(__file__).resolve().parents[3] / "firmware" / "PROTOCOL.md"
ROUNDS = "range(10)"


def client() -> str:
    """Return the program in the document's last section."""
    _, _, section = PROTOCOL.read_text().partition("## A client in 40 lines\n")
    return textwrap.dedent(section[section.index("\n    ") :]).strip()


def test_it_has_forty_lines():
    assert len(client().splitlines()) <= 40


@pytest.mark.parametrize("interrupted", [False, True])
def test_it_drives_the_robot_and_stops_it_however_it_ends(tmp_path, interrupted):
    program = tmp_path / "client.py"
    assert ROUNDS in client()
    program.write_text(client().replace(ROUNDS, "range(3)"))
    with FakeBoard() as board:
        command = [sys.executable, str(program), board.port]
        child = subprocess.Popen(command, text=True, stdout=PIPE, stderr=PIPE)
        assert board.await_state("gait")
        if interrupted:
            child.send_signal(2)
        out, err = child.communicate(timeout=LONG_S)
        assert board.await_state("hold")
    assert ("KeyboardInterrupt" in err) == interrupted == bool(err)
    if not interrupted:
        frames = [ast.literal_eval(line) for line in out.splitlines()]
        assert frames[-1]["st"] == "gait"
        assert abs(float(frames[-1]["j1"])) <= 30
        assert len({frame["t"] for frame in frames}) == len(frames) > 20
