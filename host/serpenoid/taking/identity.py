"""Whose session it is: asked when one is resumed, so that two robots never share one."""

from __future__ import annotations

import math
from dataclasses import replace

from ..base.errors import BadInput
from ..model.robot import Robot
from ..session.declaration import Field
from ..session.journal import Journal
from ..session.session import Setup
from ..session.settings import quoted
from .new_session import LENGTH, MASS, NOT_SAID, WORDS, identity_differences
from .prompt import SHORT, Again, Prompt
from .terminal import Terminal

LINKS = Field("links", "number of links", 2.0, 100.0)


def ask_identity(journal: Journal, terminal: Terminal) -> str:
    """Ask whether robot and surface are the session's, and who measures; return the latter.

    What the set-up left open is asked for and amended. Raises BadInput with the differences where
    the robot is another, Left and EOFError where the person leaves.
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
        setup, resumed = self.journal.session.setup, bool(self.journal.rows)
        if resumed:
            self._confirm(setup)
        if not setup.weighed:
            mass_kg = self._number(MASS.field, math.nan)
            if math.isfinite(mass_kg):  # else nobody has weighed it yet
                self.journal.event("amend", detail=f"robot.mass_kg = {mass_kg!r}")
        if setup.surface == NOT_SAID:
            surface = self._word("surface", "not now")
            if surface != "not now":
                self.journal.event("amend", detail=f"laboratory.surface = {quoted(surface)}")
        if not resumed:
            return setup.people
        return self.ask(f"Who measures now? Enter: {setup.people}. ") or setup.people

    def _confirm(self, setup: Setup) -> None:
        self.say(f"Resumed: {setup.name}, {in_words(setup)}.")
        answer = "?"
        while answer not in ("", "y", "yes", "n", "no"):
            answer = self.ask("Is it this robot, on this surface? Enter: yes, n: no. ").lower()
        if answer in ("n", "no"):
            refuse_another(self.journal, self._here(setup))
            self.say("Nothing differs: it is the same robot.")

    def _here(self, setup: Setup) -> Setup:
        """Return the set-up with what the person says of the robot that lies here."""
        robot = setup.robot
        self.say("What lies here, then? Enter where it is as the session has it.")
        links = round(self._number(LINKS, robot.links))
        mass_kg = self._number(MASS.field, robot.links * robot.link_mass_kg)
        length_m = self._number(LENGTH.field, robot.link_length_m)
        surface = self._word("surface", setup.surface)
        return replace(setup, robot=Robot(links, mass_kg / links, length_m), surface=surface)

    def _word(self, name: str, usual: str) -> str:
        return self.ask(f"  {WORDS[name]} [{usual}]: ") or usual

    def _number(self, field: Field, usual: float) -> float:
        """Return the number typed, `usual` for Enter."""
        shown = "not now" if math.isnan(usual) else f"{usual:.6g}"
        prompt = f"  {field.words} [{shown}]: "
        return self.number(field, prompt=prompt, usual=usual)


def in_words(setup: Setup) -> str:
    """Return robot and surface in words."""
    robot = setup.robot
    weighed = "" if setup.weighed else " (not weighed)"
    return (
        f"{robot.links} links of {1000 * robot.link_length_m:.4g} mm, "
        f"{1000 * robot.links * robot.link_mass_kg:.4g} g{weighed}, on {setup.surface}"
    )


def refuse_another(journal: Journal, here: Setup) -> None:
    """Raise BadInput, with the differences, where the robot or surface here is another."""
    lines = identity_differences(journal.session.setup, here)
    if lines:
        folder = journal.folder
        raise BadInput(
            f"{folder} is a session of another robot or surface:\n  "
            + "\n  ".join(lines)
            + f"\nbegin a session for this one: serpenoid calibrate new OTHER --template {folder}\n"
            f"if the session's own value is mistyped: serpenoid calibrate amend {folder} "
            "robot.mass_kg=480g"
        )
