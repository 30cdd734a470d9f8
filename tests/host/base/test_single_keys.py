"""Single keys: whoever reads them gives the terminal back."""

from __future__ import annotations

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


def test_the_terminal_is_given_back_and_ctrl_z_is_a_key() -> None:
    with Person([sys.executable, "-c", KEYS]) as person:
        person.sees("ready")
        assert until(lambda: person.now != person.before)
        person.presses("\x1a")
        person.sees("key b'\\x1a'")
        person.presses("q")
        assert person.leaves() == 0
        assert person.now == person.before
