"""Whose session it is: asked when one is resumed, so that two robots never share one."""

from __future__ import annotations

from ..base.errors import BadInput
from ..session.journal import Journal
from ..session.settings import Setup
from .asking import Asker, Skip, Undo
from .terminal import Terminal


def ask_identity(journal: Journal, terminal: Terminal) -> None:
    """Ask whether robot and surface are those of a session that has readings.

    No word changes the session yet: it may be another robot's. Raises BadInput where it is, Left
    and EOFError where the person leaves.
    """
    if not journal.rows:
        return
    asker = Asker(terminal)
    setup = journal.session.setup
    asker.say(f"Resumed: {setup.name}, {in_words(setup)}.")
    while True:
        try:
            answer = asker.ask("Is it this robot, on this surface? Enter: yes, n: no. ").lower()
        except (Undo, Skip):
            continue
        if answer in ("n", "no"):
            folder = journal.folder
            raise BadInput(
                f"{folder} is a session of another robot or surface ({in_words(setup)})\n"
                f"begin a session for this one: serpenoid calibrate new OTHER --template {folder}\n"
                "if the session's own value is mistyped: correct it in "
                f"{folder / 'session.toml'}"
            )
        if answer in ("", "y", "yes"):
            return


def in_words(setup: Setup) -> str:
    """Return robot and surface in words."""
    robot = setup.robot
    weighed = "" if setup.robot_table.weighs else " (not weighed)"
    return (
        f"{robot.links} links of {1000 * robot.link_length_m:.4g} mm, "
        f"{1000 * robot.links * robot.link_mass_kg:.4g} g{weighed}, on {setup.laboratory.surface}"
    )
