"""A simulated person at a terminal, who runs a command, presses keys and reads the screen."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import termios
import time

from command_line import program
from robot.patience import LONG_S


class Person:
    """Run `serpenoid LINE` or another command in a terminal; `before` holds its settings then."""

    def __init__(self, line: str | list[str]):
        self.master, self._slave = pty.openpty()
        self.before = termios.tcgetattr(self._slave)
        name = os.ttyname(self._slave)  # Ctrl-C reaches the process that opens it first
        command = program(line) if isinstance(line, str) else line
        self.process = subprocess.Popen(
            # The parent of the tests may ignore signals, as nohup and a shell's & do.
            [
                "env",
                "--default-signal",
                "sh",
                "-c",
                f'exec "$@" <{name} >{name} 2>&1',
                "sh",
                *command,
            ],
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            env={k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")},
        )
        self.screen = ""

    def __enter__(self) -> Person:
        return self

    def __exit__(self, *_: object) -> None:
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.closes()
        os.close(self._slave)

    def closes(self) -> None:
        """Close the terminal."""
        if self.master >= 0:
            os.close(self.master)
        self.master = -1

    def sees(self, text: str, most_s: float = LONG_S) -> str:
        """Wait until the screen shows a text; return the output since the last call."""
        end = time.monotonic() + most_s
        while text not in self.screen:
            if time.monotonic() > end:
                raise AssertionError(f"no {text!r} in {self.screen!r}")
            if select.select([self.master], [], [], 0.05)[0]:
                self.screen += os.read(self.master, 4096).decode("utf-8", "replace")
        output, _, self.screen = self.screen.partition(text)
        return output + text

    def answers(self, question: str, keys: str) -> None:
        """Press keys when the screen shows a text."""
        self.sees(question)
        self.presses(keys)

    def presses(self, keys: str) -> None:
        os.write(self.master, keys.encode())

    def sends(self, number: signal.Signals) -> None:
        self.process.send_signal(number)

    def leaves(self, most_s: float = LONG_S) -> int:
        """Read the screen until the command ends; return its exit status."""
        end = time.monotonic() + most_s
        while self.process.poll() is None and time.monotonic() < end:
            if select.select([self.master], [], [], 0.02)[0]:
                self.screen += os.read(self.master, 4096).decode("utf-8", "replace")
        return self.process.wait(1)

    @property
    def now(self) -> list:
        """The present settings of the terminal."""
        return termios.tcgetattr(self._slave)
