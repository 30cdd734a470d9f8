"""A person on a floor in the virtual lab, with a truth that is known and seeded.

The robot obeys the lab's equations of motion, wheels that turn and joints that stand off with it.
Who pushes it lets go a little crooked; a film, or tape and watch, then tells where it was.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ....model.drives import ServoKind
from ....model.ground import Ground
from ...crawls.filmed import crawl_cells
from ...floor.look import look_at
from ...kinds.declaration import Cells, Field
from ...session import Session, Setup
from ..steps import Step, Tracked
from ..world import RUN_S, SPEED, FloorWorld, Truth, between_links_deg

TRIES = 6  # of a push, until somebody gives up
# What a person takes, s: to turn the robot round, push it and take the film in; to bend it and lay
# the protractor on; to start a gait and lay the tape.
PUSH_S, BEND_S, GAIT_S = 40.0, 90.0, 60.0


def drawn_floor(
    setup: Setup, ground: Ground, rng: np.random.Generator, servo: ServoKind | None = None
) -> Truth:
    """Draw the errors that all readings of a session share, as the set-up says they may be.

    servo: the kind of which the robot has one drawn; None: its joints follow the gait.
    """
    slope, scale, mass, shape, across = (float(v) for v in rng.normal(size=5))
    wheels_kg = setup.floor.wheels_kg
    mass_kg = setup.robot.links * setup.robot.link_mass_kg
    rolling = (
        (0.045 + 0.03 * shape) * mass_kg
        if wheels_kg is None
        else ((0.75 + 0.15 * shape) * wheels_kg)
    )
    return Truth(
        ground,
        slope_rad=setup.floor.slope_sigma_rad * slope,
        across_rad=setup.floor.slope_sigma_rad * across,
        film_scale=1.0 + setup.floor.film_scale_sigma * scale,
        mass_scale=1.0 + setup.uncertainty.mass_sigma * mass,
        rolling_kg=max(rolling, 0.0),
        joint_sigma_rad=setup.uncertainty.joint_sigma_rad,
        servo=servo and servo.draws(1, int(rng.integers(2**31)))[0],
    )


class SimulatedFloor:
    """Do each step of the procedure against a known truth; the same seed does the same.

    t_s: the lab's clock, with what a person takes.
    """

    def __init__(self, setup: Setup, truth: Truth, seed: int = 0):
        self.truth, self.t_s = truth, 0.0
        self._setup, self._rng = setup, np.random.default_rng(seed)
        self._world = FloorWorld(setup, truth, self._rng, self._rng)
        self.robot = self._world.robot

    def answer(self, step: Step, session: Session) -> Cells | None:
        """Do a step as a person would."""
        kinds = {
            "straight": self._bend,
            "bend": self._bend,
            "coast": self._push,
            "gait": self._gait,
        }
        return kinds[step.kind](step)

    def look_again(
        self, step: Step, doubtful: Sequence[tuple[Field, tuple[float, float]]], cells: Cells
    ) -> Cells:
        """Leave what was measured as it is: a push is over."""
        return cells

    def _bend(self, step: Step) -> Cells:
        self.t_s += BEND_S
        self._world.bend(step.lambda_deg)
        if not step.lambda_deg:
            return {}
        ends = self._world.ends_rad(math.sqrt(2) * self._setup.uncertainty.lambda_sigma_rad)
        return {"between_links_deg": between_links_deg(ends)}

    def _push(self, step: Step) -> Cells | None:
        """Push until a push is as it should be; return its track, or way and time to rest."""
        for _ in range(TRIES):
            self.t_s += PUSH_S
            track = self._world.push(step, SPEED)
            if self.truth.camera is None:
                return self._world.tape(track)
            samples = self._world.film(track, self.truth.camera)
            look = look_at(*samples.T)
            if not look.doubts:
                return Tracked({**look.cells(), "by": "film"}, samples)
        return None

    def _gait(self, step: Step) -> Cells:
        gait = step.gait
        assert gait is not None  # a gait's step has one
        self.t_s += GAIT_S
        if self.truth.camera is None:
            read, duration_s = self._world.time_crawl(step, gait)
            self.t_s += duration_s
            return read
        self.t_s += RUN_S
        rows = self._world.film_crawl(step, gait, self.truth.camera)
        return Tracked({**crawl_cells(rows, gait), "film_sha256": "simulated"}, rows, "video")
