"""`serpenoid calibrate practice`: the afternoon at the treadmill, learnt at a desk."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import serpenoid as sn

from ..declare import FOLDER, Range, flag, option, refuse_typed

if TYPE_CHECKING:
    from ...calibration.taking.person.practice_treadmill import TreadmillTerminal

PICTURE_S = 0.1
ENOUGH = 4  # pushes, after which the truth may be told


@click.command()
@click.argument("folder", type=FOLDER, default=Path("practice-session"))
@option(
    "--on",
    "What to practise: stations, or pushes.",
    choice=["treadmill", "floor"],
    default="treadmill",
)
@option(
    "--seed", "Of the truth that is to be found; drawn unless given.", type=click.IntRange(0, 10**6)
)
@option(
    "--pace",
    "How many seconds pass at the treadmill in one of the clock.",
    type=Range(0.1, 50.0),
    default=1.0,
)
@option(
    "--page/--no-page",
    "with_page",
    "Serve the treadmill as a page: a picture, and buttons.",
    default=True,
)
@flag("--lan", "The page is reachable from a phone in the same net.")
def practice(
    folder: Path, on: str, seed: int | None, pace: float, with_page: bool, lan: bool
) -> None:
    """Learn the afternoon at a desk: the real dialogue, a robot on a treadmill of the lab.

    Or with --on floor the pushes, by words at the prompt; that has no page.

    The robot obeys the equations of motion: it yaws and rolls off unless you steer it. Its
    friction is told at the end. The session goes on where it was left, as a real one.
    """
    import secrets

    from ...calibration.session_file import read_session
    from ...calibration.taking.new_session import create_session, default_setup
    from ...calibration.taking.person.practice import (
        FloorTerminal,
        PracticeTerminal,
        practice_seed,
        practice_setup,
        truth_in_words,
    )
    from ...calibration.taking.person.practice_treadmill import TreadmillTerminal
    from ...calibration.taking.person.terminal import Console
    from ...robot.wire.virtual import VirtualLink
    from .calibrate_person import with_a_person

    if lan and not with_page:
        raise click.UsageError("--lan goes with --page")
    if on == "floor":
        words = "{} has no effect with --on floor; leave it out"
        refuse_typed(words, "pace", "lan", "with_page")
    if not (folder / "session.toml").exists():
        drawn = secrets.randbelow(10**6) if seed is None else seed
        setup = default_setup(os.path.basename(os.path.abspath(folder)))
        create_session(folder, practice_setup(setup, drawn, on))
    session = read_session(folder)
    has = practice_seed(session, on)
    if seed not in (None, has):
        raise sn.BadInput(f"{folder} is of seed {has}, not {seed}; give another folder")
    lab = Console(), session.setup, has, folder / "films"
    terminal: PracticeTerminal
    if on == "floor":
        link, page, terminal = None, nullcontext(), FloorTerminal(*lab)
    else:
        link = VirtualLink(joints=session.setup.robot.links - 1)
        terminal = TreadmillTerminal(*lab, link.set_points_rad, pace)
        page = _running(terminal, with_page, lan)
    terminal.say(f"{terminal.HELP}\nThese words once more: {on}.")
    try:
        with page:
            with_a_person(folder, link, 1e9, False, False, terminal, terminal.watch)
    finally:
        session = read_session(folder)
        if len(session.kept) + len(session.kept_pushes) >= ENOUGH:
            truth = truth_in_words(terminal.world.truth, on)
            terminal.say(f"\n{truth}; `serpenoid fit {folder}`")


@contextmanager
def _running(terminal: TreadmillTerminal, with_page: bool, lan: bool) -> Iterator[None]:
    """Let the treadmill's time pass while this lasts, and serve its page."""
    from importlib.resources import files

    from ...show.pages.server import Page

    def steer(way: str) -> Any:
        return lambda: terminal.keys[way]() if way in terminal.keys else "no robot to steer yet"

    room, ended = terminal.room.start(), threading.Event()
    with ExitStack() as stack:
        stack.callback(room.stop)
        if with_page:
            html = files("serpenoid.show.session").joinpath("practice.html")
            buttons = room.buttons | {way: steer(way) for way in ("left", "right")}
            page = stack.enter_context(Page(html.read_text("utf-8"), lan=lan, buttons=buttons))

            def publish() -> None:
                while not ended.wait(PICTURE_S):
                    page.publish(room.state())

            thread = threading.Thread(target=publish, daemon=True)
            thread.start()
            stack.callback(thread.join)
            stack.callback(ended.set)
            terminal.say(f"the treadmill: {page.url}")
        yield
