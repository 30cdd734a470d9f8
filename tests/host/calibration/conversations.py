"""Play the conversations in conversations/*.txt again: all that is said, by what was typed.

`» ` parts a prompt from what is typed. (nobody) does not answer, (ctrl-c) interrupts, (left 3) and
(right 1) press keys that steer, A line of === begins a
new session, with its plan and what is left out; or goes on with it.
"""

from __future__ import annotations

import re
import sys
from collections import deque
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tomllib
from serpenoid import SerpenoidError
from serpenoid.commands.friction.calibrate_person import film_reader
from serpenoid.session.journal import Journal
from serpenoid.taking.asking import Quit, Skip, Undo
from serpenoid.taking.dialogue import Dialogue, ask_identity
from serpenoid.taking.new_session import answered, create_session, default_setup, on_place
from serpenoid.taking.session_robot import SessionRobot
from serpenoid.taking.terminal import Console

FOLDER = Path(__file__).with_name("conversations")
FILES = sorted(FOLDER.glob("*.txt"))
_MARK = re.compile(r"\((nobody|ctrl-c|left|right) ?(\d*)\) ?(.*)")


class Typist(Console):
    """Types prepared lines, then leaves; a function is called for what it types."""

    def __init__(self, *lines: Any, robot: Any = None):
        self.lines, self.robot = deque(lines), robot
        self.heard = ""

    def say(self, text: str) -> None:
        self.heard += text + "\n"

    def forget(self) -> None:
        pass

    def ask(self, prompt: str, tick) -> str | None:
        tick()
        if not self.lines:
            self.heard += prompt.rstrip() + "\n"
            raise EOFError
        line = self.lines.popleft()
        line = line() if callable(line) else line
        self.heard += f"{prompt}» {line}\n"
        marked = _MARK.fullmatch(line)
        return self._marked(*marked.groups()) if marked else line

    def _marked(self, mark: str, count: str, rest: str) -> str | None:
        if mark == "nobody":
            return None
        if mark == "ctrl-c":
            raise KeyboardInterrupt
        self.robot.steer(int(count) * (1 if mark == "left" else -1))
        return rest


def begun(folder: Path, head: str) -> None:
    """Begin the session that a line of === names: its place, and its plan."""
    setup = answered(default_setup("made up"), {"people": "Ada", "surface": "belt"})
    place = "floor" if "floor" in head else "treadmill"
    changes = tomllib.loads("\n".join(re.findall(r"plan\.(\w+ = [^;]+)", head)))
    plan = replace(on_place(setup.plan, place), **changes)
    create_session(folder, replace(setup, plan=plan))
    with Journal(folder) as journal:
        for key in re.findall(r"without ([\w. ]+)", head):
            journal.event("skip", detail=key)


def talked(folder: Path, head: str, typist: Typist) -> str:
    """Return all that is said in one conversation, by what is typed."""
    try:
        with Journal(folder) as journal:
            ask_identity(journal, typist)
            Dialogue(journal, typist, film_reader(None), typist.robot).run()
    except (Quit, Skip, Undo, EOFError, KeyboardInterrupt, SerpenoidError) as error:
        typist.heard += f"({type(error).__name__}) {error}\n"
    return typist.heard.replace(str(folder), "DIR")


def played(path: Path) -> str:
    """Return a file as it is said today."""
    heads = re.split(r"^(===.*)\n", path.read_text(), flags=re.MULTILINE)
    text = heads[0]
    with TemporaryDirectory() as made:
        folder = Path(made) / "none"
        for number, (head, body) in enumerate(zip(heads[1::2], heads[2::2], strict=True)):
            lines = [line.partition("» ")[2] for line in body.splitlines() if "» " in line]
            if "new session" in head:
                folder = Path(made) / f"session{number}"
                begun(folder, head)
            text += head + "\n"
            if "robot)" in head:
                with SessionRobot("virtual:fast") as robot:
                    text += talked(folder, head, Typist(*lines, robot=robot))
            else:
                text += talked(folder, head, Typist(*lines))
    return text


if __name__ == "__main__":  # write them anew
    for file in [FOLDER / f"{name}.txt" for name in sys.argv[1:]] or FILES:
        file.write_text(played(file))
