"""Single keys: whoever reads them gives the terminal back, also while suspended."""

from __future__ import annotations

import os
import signal
import sys

from robot.patience import until
from robot.terminal import Person

KEYS = """
from serpenoid.base import system
with system.single_keys():
    print("ready", flush=True)
    while (came := system.read_input(60.0)) != b"q":
        print("key", came, flush=True)
"""


def test_the_terminal_is_given_back_while_a_program_of_keys_is_suspended() -> None:
    with Person([sys.executable, "-c", KEYS]) as person:
        person.sees("ready")
        assert until(lambda: person.now != person.before)
        person.sends(signal.SIGTSTP)
        assert os.WIFSTOPPED(os.waitpid(person.process.pid, os.WUNTRACED)[1])
        assert person.now == person.before
        person.sends(signal.SIGCONT)
        assert until(lambda: person.now != person.before)
        person.presses("k")
        person.sees("key b'k'")
        person.presses("q")
        assert person.leaves() == 0
        assert person.now == person.before
