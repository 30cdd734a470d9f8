"""The demo's floor: the same robot pushed in the virtual lab, with no treadmill at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...calibration.advising.two_fits import two_fits
from ...calibration.friction_fit import fit_friction
from ...calibration.kinds.instruments import FloorTools
from ...calibration.taking.floor.simulated import SimulatedFloor, drawn_floor
from ...calibration.taking.journal import Journal
from ...calibration.taking.new_session import default_setup, on_place
from ...calibration.taking.treadmill import take_all
from ...model.errors import BadInput
from ...show import report
from ...show.session.floor_figure import push_figure
from .loop import begin_anew, say, truth_table

if TYPE_CHECKING:
    from ...calibration.friction_result import FrictionFit
    from ...calibration.session import Session, Setup
    from ...model.ground import Ground
    from ...model.robot import Robot

SEED, WHEELS_KG = 2005, 0.036


def push_along_floor(out: Path, belt: FrictionFit, ground: Ground) -> dict[str, Any] | None:
    """Take pushes there and back in each bend, fit them, and hold them beside the treadmill's fit.

    ground: the truth. The session is left in out/floor, its picture in out/floor.png. Returns the
    figures; None where a robot of one's own does not roll well enough to tell.
    """
    say("[6/8] no treadmill? The same robot, pushed along a floor and filmed")
    try:
        session, minutes = _pushed(out / "floor", _setup(belt.robot), ground)
        fit = fit_friction(session)
    except BadInput as error:
        say(f"      not told: {error}")
        return None
    say(
        f"      {len(session.kept_pushes)} pushes, there and back in {_bends(session)} bends: "
        f"{minutes:.0f} minutes by the lab's clock"
    )
    truth_table(fit, ground)
    beside = two_fits(belt, fit)
    say(f"      treadmill and floor: {beside.verdict}")
    push_figure(session, fit, out / "floor.png")
    say(f"      places over the law, and what is left: {out / 'floor.png'}")
    return {"fit": fit.to_dict(), "beside": beside.to_dict()}


def _setup(body: Robot) -> Setup:
    setup = default_setup("demo, floor")
    plan = replace(on_place(setup.procedure, "floor"), gaits=(), pushes=2)
    return replace(
        setup,
        kind="simulated",
        source=f"a floor in the virtual lab, seed {SEED}",
        robot=body,
        note="the demo's: no measurement",
        surface="simulated floor",
        procedure=plan,
        floor=FloorTools(wheels_kg=WHEELS_KG),
    )


def _pushed(folder: Path, setup: Setup, ground: Ground) -> tuple[Session, float]:
    """Take the session; return it and the minutes that a person would have needed."""
    begin_anew(folder, setup)
    truth = drawn_floor(setup, ground, np.random.default_rng(SEED))
    person = SimulatedFloor(setup, truth, SEED)
    with Journal(folder) as journal, report.busy("pushes"):
        return take_all(journal, person), person.t_s / 60


def _bends(session: Session) -> int:
    return len({push.lambda_rad for push in session.kept_pushes})
