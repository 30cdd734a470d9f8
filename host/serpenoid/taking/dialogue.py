"""The person at the treadmill or on a floor: each step said, each number asked for and kept."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ..base.errors import BadInput, CommandRefused, RecordingFailed, RobotError
from ..model.gait import Gait
from ..session.declaration import Field, Values
from ..session.journal import Journal
from ..session.session import Session
from ..session.track import EXAMPLE, tidy_places
from .asking import PATIENCE_S, WORDS, Again, Asker, Left, Skip, Undo, questions
from .films import FilmReader, named_file, no_films, read_crawl, take_track
from .procedure import ZERO_BEFORE, doubts, next_step
from .session_robot import SessionRobot
from .steps import NEAR_DEG, Step, Tracked, step_in_words
from .terminal import Terminal
from .track_files import read_track_file
from .treadmill import posed_after, record_step

QUESTIONS = {  # of steps that a film answers, too
    "push": "its film or track (of Tracker, Kinovea, CSV)",
    "gait": "its film",
}
DRIFT = (
    "drift left over, + uphill (m/s), and deg turned, + to the left, as 0.01 3deg (Enter: none); "
    f"or places as s:m, {EXAMPLE}, or their table"
)
LEFT = "Left. Everything read so far is kept; the same command goes on from here."
Told = Callable[[Session, Step], None]


class Dialogue:
    """Take a session step by step with a person.

    robot, patience_s, clock_s: as of an Asker. told: called with session and step when a step
    begins. film: what reads a film.
    """

    def __init__(
        self,
        journal: Journal,
        terminal: Terminal,
        robot: SessionRobot | None = None,
        told: Told = lambda session, step: None,
        patience_s: float = PATIENCE_S,
        clock_s: Callable[[], float] = time.monotonic,
        film: FilmReader = no_films,
    ):
        self.journal, self._robot, self._told, self._film = journal, robot, told, film
        self._asker = Asker(terminal, journal, robot, patience_s, clock_s)
        self._say = self._asker.say
        self._bend_deg: float | None = None  # how the robot lies, by the plan; None: not known
        self._listed = 0  # the last reading that was listed
        if robot is not None:
            robot.offset_rad = steered_rad(journal.session) or 0.0

    def run(self) -> bool:
        """Go on until everything is done or the person leaves; return False if a robot is lost."""
        self._say(WORDS)
        try:
            if self._robot is not None:
                self._say("Esc or space stops the robot; Ctrl-C stops it and leaves.")
            while self._one_step():
                pass
        except (Left, EOFError):
            self._say(LEFT)
        except KeyboardInterrupt:
            self._say(f"\n{LEFT}")
            raise
        except RobotError as error:
            self._say(f"! the robot: {error}\n  {LEFT}")
            return False
        finally:
            self._asker.let_go()
        return True

    def _too_far(self, bend_deg: float, reach_deg: float) -> str:
        name = "push_lambda_deg" if self._on_floor else "lambda_deg"
        return (
            f"bend {bend_deg:g} deg: joint limits and steering leave room for {reach_deg:g} deg. "
            f"Leave it out by `skip`; or plan less: {name} in "
            f"{self.journal.folder / 'session.toml'}"
        )

    @property
    def _bend(self) -> str:
        return self.journal.session.setup.plan.bend

    @property
    def _on_floor(self) -> bool:
        return self.journal.session.setup.plan.on == "floor"

    def _one_step(self) -> bool:
        """Do one step; return False at the end."""
        self._read_again()
        if self._robot is not None and not self._robot.powered:
            self._bend_deg = None
        step = next_step(self.journal.session, self._bend_deg)
        self._told(self.journal.session, step)
        if step.kind in ("straight", "bend", "done"):
            self._list_readings()
        self._say(f"\n{step.say}")
        if step.kind == "done":
            return False
        try:
            try:
                self._do(step)
            except Skip:
                self._leave_out(step)
            except Undo:
                self._undo()
        except (BadInput, RecordingFailed, CommandRefused) as error:
            self._say(f"! {error}")
        except Again:
            pass
        if step.kind == "gait":
            self._asker.let_go()
        return True

    def _read_again(self) -> None:
        """Read the files again, and say what somebody changed in session.toml meanwhile."""
        while True:
            try:
                for line in self.journal.read_again():
                    self._say(f"session.toml: {line}")
                return
            except BadInput as error:
                self._say(f"! {error}")
                self._asker.confirm("  Enter when that is mended: ")

    def _list_readings(self) -> None:
        """Show the readings since the last pose, so that `undo 7` can name one."""
        for r in self.journal.session.readings:
            if r.number > self._listed:
                state = f"  void: {r.comment}" if r.voided else ""
                self._say(f"  {r.number:4}  {'  '.join(r.in_words())}{state}")
        self._listed = self.journal.last

    def _leave_out(self, step: Step) -> None:
        self.journal.event("skip", self.journal.last, step.key)
        self._say(f"  left out: {step_in_words(step.key)}; undo takes it up again")
        if step.key == ZERO_BEFORE:
            zero_rad = self.journal.session.setup.instruments.incline_zero_sigma_rad
            self._say(
                f"  ! {math.degrees(zero_rad):.2g} deg are then assumed of the inclinometer's "
                "zero; 0.3 deg are 17 % of the 2005 robot's ft0"
            )
        elif step.kind == "straight":
            self._say("  ! without straight readings nothing can be fitted")

    def _undo(self) -> None:
        """Take up again what was left out since the last reading; else void that reading."""
        session, last = self.journal.session, self.journal.last
        skips = [e.detail for e in session.events if e.event == "skip" and e.reading == last]
        left_out = [key for key in skips if key in session.skipped]
        kept = [r.number for r in session.readings if not r.voided]
        if left_out:
            self.journal.event("unskip", detail=left_out[-1])
            self._say(f"  no longer left out: {step_in_words(left_out[-1])}")
        elif kept:
            self.journal.event("undo", max(kept))
            self._say(f"  reading {max(kept)} is void")
        else:
            self._say("  ! there is no reading yet")

    def _do(self, step: Step) -> None:
        if step.kind in ("straight", "bend"):
            self._pose(step)
        elif step.gait is not None and self._robot is not None:
            self._asker.confirm("Lay it straight. Enter starts the robot: ", ahead=False)
            self._robot.go(step.gait)
        number = self._asker.form(lambda: self._taken(step))
        self._bend_deg = posed_after(step, self._bend_deg)
        if number:
            self._say(f"kept as reading {number}")

    def _pose(self, step: Step) -> None:
        robot = self._robot
        if robot is None:
            if step.kind == "straight":
                self._asker.confirm("Enter when it lies so: ")
            return
        while step.lambda_deg and (reach := robot.reach_deg(self._bend)) < step.lambda_deg:
            if reach >= step.lambda_deg - NEAR_DEG:
                self._say(f"  Joint limits and steering leave room for {reach:g} deg: it is so.")
                break
            self._say(f"! {self._too_far(step.lambda_deg, reach)}")
            self._asker.confirm("  skip, or quit: ")
        what = "bends" if step.lambda_deg else "straightens"
        self._asker.confirm(f"Enter {what} the robot (hands off): ", ahead=False)
        reach = robot.reach_deg(self._bend) if step.lambda_deg else 0.0
        robot.pose(min(step.lambda_deg, reach), self._bend)
        self._steer(robot, step)

    def _steer(self, robot: SessionRobot, step: Step) -> None:
        """Have the offset found that runs straight, before the first reading; it is kept."""
        left_out = "steering" in self.journal.session.skipped
        if step.lambda_deg or left_out or steered_rad(self.journal.session) is not None:
            return
        if self._on_floor:
            return self._say(
                "  Left and right keys bend every joint a little, at every prompt. Where a push "
                "turns the robot, steer against it before the next; each push keeps the offset."
            )
        self._say(
            "  Incline as for the first station, and raise the belt until the robot nearly holds "
            "its place: on a level belt it is carried off. Left and right keys bend every joint a "
            "little: steer until the robot runs straight by itself."
        )
        try:
            self._asker.confirm("  Enter keeps it; skip leaves the steering out alone: ")
        except Skip:
            return self._leave_out(replace(step, kind="", key="steering"))
        return self._say(f"  every joint has {math.degrees(robot.offset_rad):+.2f} deg from now on")

    def _taken(self, step: Step) -> int:
        """Ask for a step's reading and keep it; return its number, 0 where none is kept."""
        values = self._station(step) if step.kind == "station" else self._values(step)
        if step.kind in ("station", "push") and not isinstance(values, Tracked):
            values |= self._steering()
        unit = self.journal.session.setup.instruments.belt_speed_unit
        if not isinstance(values, Tracked):
            values = self._asker.sure(
                values, lambda typed: doubts(self.journal.session, step, typed), unit
            )
        elif step.gait is not None and self._robot is not None:
            values["omega_rad_s"] = self._robot.rate(step.gait)
        while True:
            try:
                return record_step(self.journal, step, values)
            except RecordingFailed as error:
                self._say(f"! {error}")
                self._asker.ask("  Enter tries again: ")

    def _values(self, step: Step) -> Values:
        """Return a step's numbers, or what a film or a table of its track shows."""
        typed = ""
        if step.kind in QUESTIONS:
            while not typed:
                numbers = questions(step.asked)
                typed = self._asker.ask(f"  {QUESTIONS[step.kind]}; or {numbers}: ")
            named = named_file(typed)
            if named is not None and step.gait is not None:
                return self._crawl(named[0], step.gait)
            if named is not None:
                self._pushes(*named, {**step.cells, **self._steering()})
        unit = self.journal.session.setup.instruments.belt_speed_unit
        values = self._asker.numbers(step.asked, typed, unit)
        if step.gait is not None and self._robot is not None:
            values["omega_rad_s"] = self._robot.rate(step.gait)
        return values

    def _station(self, step: Step) -> Values:
        """Return what is read of a station; the belt settles from its speed's answer on."""
        ask, setup = self._asker, self.journal.session.setup
        fields = {field.column: field for field in step.asked}
        set_up = fields["incline_deg"], fields["belt_speed_m_s"]
        values = ask.numbers(set_up, unit=setup.instruments.belt_speed_unit)
        set_s = ask.answered_s
        text = ask.ask(f"  let it settle {step.settle_s:.0f} s; then {DRIFT}: ")
        places = self._places(text)
        if places:
            return values | {"places": places}
        values["waited_s"] = round(ask.answered_s - set_s, 1)
        return values | self._drift(fields["drift_m_s"], fields["turned_deg"], text)

    def _drift(self, drift: Field, turned: Field, text: str) -> Values:
        """Return the drift in a line, and by how much the robot turned, in deg, behind it."""
        found = re.search(r"[+-]?[\d.,]+\s*(deg|°)\s*$", text)
        rest = text if found is None else text[: found.start()]
        values = Values({drift.column: 0.0, turned.column: 0.0})
        if rest.strip():
            values |= self._asker.numbers([drift], rest)
        if found is not None:
            values |= self._asker.numbers([turned], found[0])
        return values

    def _places(self, text: str) -> str:
        """Return the places over time that were typed, or are in a table; "" where none are."""
        named = named_file(text)
        if named is not None:
            track = read_track_file(*named, pushed=False).values
            return tidy_places(" ".join(f"{t - track[0, 0]:.6g}:{x:.6g}" for t, x, _ in track))
        return tidy_places(text) if ":" in text else ""

    def _steering(self) -> Values:
        """Return the offset that steers, as a reading keeps it."""
        if self._robot is None:
            return {}
        return {"offset_deg": round(math.degrees(self._robot.offset_rad), 3)}

    def _crawl(self, path: Path, gait: Gait) -> Tracked:
        crawl = read_crawl(self.journal, path, gait, self._film)
        gains = ", ".join(f"{float(gain):.3f}" for gain in str(crawl["gains"]).split(","))
        self._say(
            f"  {float(crawl['speed_m_s']):.4f} m/s; joints' amplitudes over the commanded one, "
            f"from the tail: {gains}"
        )
        return crawl

    def _pushes(self, path: Path, unit: str | None, cells: Values) -> None:
        """Keep all pushes of a file, however many, and raise Again: the plan has moved on."""
        for one in take_track(self.journal, path, unit, cells, self._film, self._note):
            self._say(f"  {one.in_words()}")
        raise Again

    def _note(self, text: str) -> None:
        self._say(f"  {text}")


def steered_rad(session: Session) -> float | None:
    """Return the steering on every joint at the last reading that kept it; None before."""
    kept = [r for r in (*session.of("station"), *session.of("push")) if r.offset_rad is not None]
    return max(kept, key=lambda r: r.number).offset_rad if kept else None
