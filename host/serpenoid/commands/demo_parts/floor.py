"""The demo's floor: the same robot pushed in the virtual lab, with no treadmill at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...calibration.advising.two_fits import two_fits
from ...calibration.fit_file import save_fit
from ...calibration.friction_fit import fit_friction
from ...calibration.kinds.instruments import FloorTools
from ...calibration.taking.journal import Journal
from ...calibration.taking.new_session import default_setup, on_place
from ...calibration.taking.simulated import SimulatedPerson
from ...calibration.taking.treadmill import take_all
from ...calibration.taking.world import drawn_floor
from ...model.errors import BadInput
from ...show.progress import working
from ...show.session.floor_figure import push_figure
from .loop import begin_anew
from .words import beside_truth, step

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
    try:
        session, minutes = _pushed(out / "floor", _setup(belt.robot), ground)
        fit = fit_friction(session)
    except BadInput as error:
        step(6, f"No pushes along a floor for this robot: {error}")
        return None
    save_fit(fit, out / "floor")
    beside = two_fits(belt, fit)
    push_figure(session, fit, out / "floor.png")
    step(
        6,
        f"No treadmill? {len(session.kept_pushes)} filmed pushes along a floor in "
        f"{_bends(session)} bends, {minutes:.0f} minutes: {beside_truth(fit, ground)}",
        f"Treadmill and floor: {beside.verdict}",
    )
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
    person = SimulatedPerson(setup, truth, SEED)
    with Journal(folder) as journal, working("pushes"):
        return take_all(journal, person), person.t_s / 60


def _bends(session: Session) -> int:
    return len({push.lambda_rad for push in session.kept_pushes})
