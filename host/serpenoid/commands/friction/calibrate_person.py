"""Take a session with a person at the terminal, with or without a connected robot."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from pathlib import Path

from ...base.errors import RecordingFailed, SerpenoidError
from ...friction.fit import fit_friction
from ...model.gait import Gait
from ...model.robot import Robot
from ...robot.wire.link import Link
from ...session.journal import PROGRAM, Journal
from ...session.session import Session
from ...show.screen import say
from ...taking.asking import Quit, Skip, Undo
from ...taking.dialogue import Dialogue, ask_identity
from ...taking.films import FilmReader
from ...taking.procedure import Tracked
from ...taking.session_robot import SessionRobot
from ...taking.terminal import Console
from ...video.made_gait import film_cells
from ...video.measure_film import measure_film
from ...video.pushed import track_pushes
from ..options import busy


def with_a_person(folder: Path, port: str | Link | None) -> None:
    """Take or resume a session at the terminal; the exit status is 1 if the robot was lost."""
    console = Console()
    with ExitStack() as stack:
        journal = stack.enter_context(Journal(folder))
        for note in journal.session.notes:
            console.say(f"note: {note}")
        setup = journal.session.setup
        console.say(f"{journal.session}; on {setup.laboratory.surface}: {setup.in_words()}")
        try:
            ask_identity(journal, console)
        except (Quit, Undo, Skip, EOFError):
            return console.say("Left; nothing was changed.")
        robot = None
        if port is not None:
            robot = stack.enter_context(SessionRobot(port, setup.robot.links - 1))
            console.keys = {
                "left": lambda: robot.steer(1),
                "right": lambda: robot.steer(-1),
                "\x1b": robot.stop,
                " ": robot.stop,
            }
        journal.event("start", detail=PROGRAM)
        if robot is not None:
            journal.event("connect", detail=robot.greeting)
            console.say(f"robot: {robot.greeting}")
        film = film_reader(setup.robot_table.tag_side_m)
        shown = [""]

        def show_fit(session: Session) -> None:
            """Say what the readings tell by now, unless that was just said."""
            if (text := _present_fit(session)) != shown[-1]:
                console.say(text)
                shown.append(text)

        dialogue = Dialogue(journal, console, film, robot, show_fit)
        try:
            well = dialogue.run()
        finally:
            with suppress(RecordingFailed):  # The person has been told that the disk is full.
                journal.event("end")
    if not well:
        raise SystemExit(1)
    return None


def _present_fit(session: Session) -> str:
    """Return the present fit in words, or what it still needs."""
    if {reading.lambda_rad > 0.0 for reading in session.fitted} != {False, True}:
        return "no fit yet: it needs readings of the straight and of the bent robot"
    try:
        fit = fit_friction(session)
    except SerpenoidError as error:
        return f"no fit yet: {str(error).removeprefix(f'{session.where}: ')}"
    values = ", ".join(
        f"{row.name.removesuffix('_whole')} {row.value:.3g} ± {row.sigma:.1g} {row.unit}"
        for row in fit.rows()
    )
    return "\n".join([f"so far, whole snake: {values}", fit.chi2_in_words, *fit.alarms])


def film_reader(side_m: float | None, capture_fps: float | None = None) -> FilmReader:
    """Return a reader of films of a robot with tags, which needs the extra `video`.

    side_m: side of a tag; None: as the printed sheet has it. capture_fps: frames a second
    that the camera recorded, for slow motion whose file does not state it.
    """

    def read(path: Path, robot: Robot, gait: Gait | None) -> Tracked:
        arguments = path, robot.links, robot.link_length_m, side_m
        what = f"watching {path.name}"
        if gait is not None:
            crawl = busy(
                what, lambda share: measure_film(*arguments, gait, False, share, capture_fps)
            )
            remarks, (cells, samples) = list(crawl.run.remarks), film_cells(crawl)
        else:
            samples, scale_sigma, remarks = busy(
                what, lambda share: track_pushes(*arguments, share, capture_fps)
            )
            cells = {"scale_sigma": round(scale_sigma, 6)}
        for remark in remarks:
            say(f"{path.name}: {remark.name}: {remark.text}")
        return Tracked(cells, samples, "" if gait is None else "video")

    return read
