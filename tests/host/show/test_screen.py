"""One gate to the terminal: a file, a board or a user shows text, and commands no terminal."""

from __future__ import annotations

import json
import os
import pty
import re
import subprocess
from pathlib import Path

import serpenoid as sn
from command_line import program
from serpenoid.base.files import visible
from serpenoid.show.screen import screen

ROOT = Path(__file__).parents[3]
FOLDER_2005 = ROOT / "calibration_data" / "nirakh-2005"
EVIL = "\x1b]0;owned\x07\x1b[2J\x9b31m"


def on_a_terminal(line: str) -> bytes:
    """Return all that a command writes to a pseudo-terminal."""
    ours, theirs = pty.openpty()
    child = subprocess.Popen(
        program(line),
        stdout=theirs,
        stderr=theirs,
        stdin=subprocess.DEVNULL,
    )
    os.close(theirs)
    shown = b""
    try:
        while part := os.read(ours, 65536):
            shown += part
    except OSError:  # Linux says so that the other end is closed
        pass
    child.wait(60)
    os.close(ours)
    return shown


def obeyed(shown: bytes) -> bool:
    return b"\x1b]0;owned" in shown or b"\x1b[2J" in shown or b"\x07" in shown


def test_control_characters_are_written_out() -> None:
    assert visible(EVIL) == r"\x1b]0;owned\x07\x1b[2J\x9b31m"
    assert visible("a\tb\nc é −") == "a\tb\nc é −"
    console = screen(record=True, file=open(os.devnull, "w"))  # noqa: SIM115
    console.print(EVIL)
    assert not obeyed(console.export_text(styles=True).encode())


def test_no_file_commands_the_terminal(tmp_path: Path) -> None:
    recording = tmp_path / "run.wire"
    recording.write_text(f"# serpenoid wire 1, begun x\n{EVIL} < hello\n")
    shown = on_a_terminal(f"view {recording}")
    assert b"it is not `SECONDS < LINE`" in shown
    assert not obeyed(shown)
    fit = sn.save_fit(sn.fit_friction(sn.load_session(FOLDER_2005)), tmp_path / "fit.json")
    from serpenoid.friction import file as fit_file

    given = json.loads(fit.read_text())
    given["alarms"], given["notes"] = [f"an alarm {EVIL}"], [f"a note {EVIL}"]
    del given["sha256"]
    fit.write_text(json.dumps(given | {"sha256": fit_file.hash_of(given)}))
    gait = "--alpha-deg 70 --beta-deg 75 --frequency-hz 0.5"
    shown = on_a_terminal(f"steady {gait} --robot {fit} --servo ideal")
    assert b"an alarm" in shown
    assert not obeyed(shown)


def test_commands_have_no_other_way_to_the_terminal() -> None:
    for path in (ROOT / "host" / "serpenoid" / "commands").rglob("*.py"):
        assert not re.search(r"click\.echo\(|\bprint\(", path.read_text().replace(".print(", "")), (
            path
        )
