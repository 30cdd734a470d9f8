"""The person at the treadmill or on a floor: each step said, each number asked for and kept."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

from ..base.errors import BadInput, CommandRefused, RecordingFailed, RobotError
from ..session.declaration import Values
from ..session.journal import Journal
from ..session.session import Session
from .asking import WORDS, Asker, Quit, Restart, Skip, Undo
from .films import FilmReader, named_file, push_in_words, take_track
from .procedure import Step, Tracked, expected_ranges, next_step, record_step
from .session_robot import SessionRobot
from .terminal import Console
from .track_files import read_track_file

FILE_WORDS = {  # prompts of steps that a file answers, too
    "push": "its film or track (of Tracker, Kinovea, CSV); or way (m), time (s) and turn (deg) "
    "from the hand to rest",
    "gait": "its film; or time (s) and distance between the marks (m)",
    "station": "let it settle {:.0f} s; then drift left over (m/s) and turn, or places (Enter: "
    "none)",
}
QUIT_WORDS = "Left. Everything read so far is kept; the same command goes on from here."


class Dialogue:
    """Take a session step by step with a person.

    film: what reads a film. robot: None if it is set by hand. show_fit: called with the session
    after each station or push.
    """

    def __init__(
        self,
        journal: Journal,
        terminal: Console,
        film: FilmReader,
        robot: SessionRobot | None = None,
        show_fit: Callable[[Session], object] = lambda session: None,
    ):
        self.journal, self._robot, self._show_fit, self._film = journal, robot, show_fit, film
        self._asker = Asker(terminal, journal, robot)
        self._say = self._asker.say
        self._bend_deg: float | None = None  # how the robot lies, by the plan; None: not known
        self._listed = 0  # the last reading that was listed
        if robot is not None:
            robot.offset_rad = steering_rad(journal.session) or 0.0

    def run(self) -> bool:
        """Go on until everything is done or the person leaves; return False if a robot is lost."""
        self._say(WORDS)
        try:
            if self._robot is not None:
                self._say(
                    "Left and right keys bend every joint a little, at every prompt: where the "
                    "robot turns, steer against it; each reading keeps the offset. Esc or space "
                    "stops it, Ctrl-C stops it and leaves."
                )
            while self._take_step():
                pass
        except (Quit, EOFError):
            self._say(QUIT_WORDS)
        except KeyboardInterrupt:
            self._say(f"\n{QUIT_WORDS}")
            raise
        except RobotError as error:
            self._say(f"! the robot: {error}\n  {QUIT_WORDS}")
            return False
        finally:
            if self._robot is not None:
                self._robot.idle()
        return True

    def _take_step(self) -> bool:
        """Do one step; return False at the end."""
        self._read_again()
        self._asker.belt_unit = self.journal.session.setup.instruments.belt_speed_unit
        if self._robot is not None and not self._robot.powered:
            self._bend_deg = None
        step = next_step(self.journal.session, self._bend_deg)
        if step.kind in ("straight", "bend", "done"):
            self._list_readings()
        self._say(f"\n{step.say}")
        if step.kind == "done":
            return False
        try:
            try:
                self._do(step)
            except Skip:
                self.journal.event("skip", self.journal.last, step.key)
                self._say(f"  left out: {step.key}; undo takes it up again")
            except Undo:
                self._undo()
        except (BadInput, RecordingFailed, CommandRefused) as error:
            self._say(f"! {error}")
        except Restart:
            pass
        if self._robot is not None and step.kind == "gait":
            self._robot.idle()
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

    def _undo(self) -> None:
        """Take up again what was left out since the last reading; else void that reading."""
        session, last = self.journal.session, self.journal.last
        skips = [e.detail for e in session.events if (e.event, e.reading) == ("skip", last)]
        left_out = [key for key in skips if key in session.skipped]
        numbers = [r.number for r in session.readings if not r.voided]
        if left_out:
            self.journal.event("unskip", detail=left_out[-1])
            self._say(f"  no longer left out: {left_out[-1]}")
        elif numbers:
            self.journal.event("undo", max(numbers))
            self._say(f"  reading {max(numbers)} is void")
        else:
            self._say("  ! there is no reading yet")

    def _do(self, step: Step) -> None:
        """Move the robot as a step asks, ask for its reading, and keep it."""
        robot, bends = self._robot, "bends" if step.lambda_deg else "straightens"
        if step.kind in ("straight", "bend") and robot is not None:
            self._asker.confirm(f"Enter {bends} the robot (hands off): ", moves=True)
            session = self.journal.session
            robot.pose(step.lambda_deg, session.setup.plan.bend)
            on_belt = session.setup.plan.on == "treadmill" and step.kind == "straight"
            if on_belt and steering_rad(session) is None:
                self._say(
                    "Incline as for the first station, and raise the belt until the robot nearly "
                    "holds its place: on a level belt it is carried off. Steer until it runs "
                    "straight by itself."
                )
                with suppress(Skip):
                    self._asker.confirm("Enter keeps the steering: ")
        elif step.kind == "straight":
            self._asker.confirm("Enter when it lies so: ")
        elif step.gait is not None and robot is not None:
            self._asker.confirm("Lay it straight. Enter starts the robot: ", moves=True)
            robot.run(step.gait)
        number = self._asker.form(lambda: self._record(step))
        self._bend_deg = step.posed_deg
        if number:
            self._say(f"kept as reading {number}")
        if step.kind in ("station", "push"):
            self._show_fit(self.journal.session)

    def _record(self, step: Step) -> int:
        """Ask for a step's reading and keep it; return its number, 0 where none is kept."""
        values = self._values(step)
        if self._robot is not None and step.gait is not None:
            values["omega_rad_s"] = self._robot.rate(step.gait)
        if not isinstance(values, Tracked):
            if step.kind in ("station", "push"):
                values |= self._steering()
            expected = partial(expected_ranges, self.journal.session, step)
            values = self._asker.sure(step.fields, values, expected)
        while True:
            try:
                return record_step(self.journal, step, values)
            except RecordingFailed as error:
                self._say(f"! {error}")
                self._asker.ask("  Enter tries again: ")

    def _values(self, step: Step) -> Values:
        """Return a step's numbers, or what a film or a table of its track shows."""
        ask, count = self._asker, 2 if step.kind == "station" else 0
        values, fields, line = ask.numbers(step.fields[:count]), step.fields[count:], ""
        if step.kind in FILE_WORDS:
            line = ask.ask(f"  {FILE_WORDS[step.kind].format(step.settle_s)}: ")
            file = named_file(line)
            if file is not None and step.gait is not None:
                return self._film(file[0], self.journal.session.setup.robot, step.gait)
            if file is not None and step.kind == "push":
                self._keep_pushes(*file, {**step.cells, **self._steering()})
            if file is not None:
                track, _ = read_track_file(*file)
                line = " ".join(f"{t - track[0, 0]:.6g}:{x:.6g}" for t, x, _ in track)
            if ":" in line:
                return values | {"places": line}
            if step.kind == "station":
                line = line or "0"
        return values | ask.numbers(fields, line)

    def _steering(self) -> Values:
        """Return the offset that steers, as a reading keeps it."""
        if self._robot is None:
            return {}
        return {"offset_deg": round(math.degrees(self._robot.offset_rad), 3)}

    def _keep_pushes(self, path: Path, unit: str | None, cells: Values) -> None:
        """Keep all pushes of a file, however many, and raise Restart: the plan has moved on."""
        tell = lambda text: self._say(f"  {text}")  # noqa: E731
        for push in take_track(self.journal, path, unit, cells, self._film, tell):
            tell(push_in_words(push))
        self._show_fit(self.journal.session)
        raise Restart


def steering_rad(session: Session) -> float | None:
    """Return the steering on every joint at the last reading that has it; None before."""
    offsets = [
        reading.offset_rad
        for reading in session.readings
        if reading.kind in ("station", "push") and reading.offset_rad is not None
    ]
    return offsets[-1] if offsets else None


def ask_identity(journal: Journal, terminal: Console) -> None:
    """Ask whether robot and surface are those of a session that has readings.

    So two robots never share a session, and no word changes one yet: it may be another's. Raises
    Quit, Undo, Skip and EOFError where the person leaves.
    """
    if journal.rows:
        terminal.say(
            "Another robot or surface is another session: serpenoid calibrate new OTHER "
            f"--template {journal.folder}; what is mistyped is corrected in "
            f"{journal.folder / 'session.toml'}."
        )
        Asker(terminal).confirm("Enter if it is this robot, on this surface; quit if not: ")
