"""Whose session it is: asked when one is resumed, so that two robots never share one."""

from __future__ import annotations

from ..base.errors import BadInput
from ..session.journal import Journal
from ..session.settings import Setup, identity_differences
from .prompt import SHORT, Again, Prompt
from .terminal import Terminal


def ask_identity(journal: Journal, terminal: Terminal) -> str:
    """Ask whether robot and surface are the session's, and who measures; return the latter.

    Raises BadInput where the robot is another, Left and EOFError where the person leaves.
    """
    while True:
        try:
            return _Identity(journal, terminal).people()
        except Again:
            continue


class _Identity(Prompt):
    def _obeyed(self, line: str, enter: bool) -> bool:
        """Obey no word that changes a session: it may be another robot's."""
        word = line.lower()
        return SHORT.get(word, word) in ("help", "quit") and super()._obeyed(line, enter)

    def people(self) -> str:
        """Ask all; return who measures."""
        setup = self.journal.session.setup
        if not self.journal.rows:
            return setup.laboratory.people
        self.say(f"Resumed: {setup.name}, {in_words(setup)}.")
        answer = "?"
        while answer not in ("", "y", "yes", "n", "no"):
            answer = self.ask("Is it this robot, on this surface? Enter: yes, n: no. ").lower()
        if answer in ("n", "no"):
            raise BadInput(_another(journal=self.journal))
        people = setup.laboratory.people
        return self.ask(f"Who measures now? Enter: {people}. ") or people


def in_words(setup: Setup) -> str:
    """Return robot and surface in words."""
    robot = setup.robot
    weighed = "" if setup.robot_table.weighs else " (not weighed)"
    return (
        f"{robot.links} links of {1000 * robot.link_length_m:.4g} mm, "
        f"{1000 * robot.links * robot.link_mass_kg:.4g} g{weighed}, on {setup.laboratory.surface}"
    )


def refuse_another(journal: Journal, here: Setup) -> None:
    """Raise BadInput, with the differences, where the robot or surface here is another."""
    lines = identity_differences(journal.session.setup, here)
    if lines:
        raise BadInput(_another(journal, lines))


def _another(journal: Journal, lines: list[str] | None = None) -> str:
    """Return what to do about a session of another robot or surface. lines: the differences."""
    folder, here = journal.folder, in_words(journal.session.setup)
    differences = "".join(f"\n  {line}" for line in lines or [])
    return (
        f"{folder} is a session of another robot or surface ({here}){differences}\n"
        f"begin a session for this one: serpenoid calibrate new OTHER --template {folder}\n"
        f"if the session's own value is mistyped: correct it in {folder / 'session.toml'}"
    )
