"""A person on a floor in the virtual lab, with a truth that is known and seeded.

The robot obeys the lab's equations of motion, wheels that turn and joints that stand off with it.
Who pushes it lets go a little crooked; a film, or tape and watch, then tells where it was.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....lab.crawl import crawl_speed, filmed_crawl
from ....lab.floor import Floor, Push
from ....lab.recording import Camera, film, to_rest
from ....lab.robot import pose_of
from ....model.bends import balanced_signs
from ....model.drives import ServoKind
from ....model.errors import BadInput
from ....model.gait import Gait
from ....model.ground import Ground
from ...crawls.filmed import crawl_cells
from ...floor.look import look_at
from ...kinds.declaration import Cells, Field
from ...session import Session, Setup
from ..simulated import RobotTruth, timed_crawl
from ..steps import Step, Tracked

PHONE = Camera()
SPEED, SPEED_SIGMA = 0.9, 0.12  # m/s, of pushes, and how they scatter, relative
CROOKED_RAD, SPIN_RAD_S = 0.015, 0.06
TRIES = 6  # of a push, until somebody gives up
RUN_S = 40.0  # of a crawl that is filmed
SPEED_OFF, GAIN_OFF = 0.002, 0.002  # of a filmed crawl: its scale, each joint's amplitude
# What a person takes, s: to turn the robot round, push it and take the film in; to bend it and lay
# the protractor on; to start a gait and lay the tape.
PUSH_S, BEND_S, GAIT_S = 40.0, 90.0, 60.0


@dataclass(frozen=True)
class FloorTruth(RobotTruth):
    """What a person on the floor does not know.

    slope_rad, across_rad: of the floor, towards "there" and to the left of it. film_scale: lengths
    seen over true. camera: what films; None: tape and watch.
    """

    slope_rad: float = 0.0
    across_rad: float = 0.0
    film_scale: float = 1.0
    camera: Camera | None = PHONE


def drawn_floor(
    setup: Setup, ground: Ground, rng: np.random.Generator, servo: ServoKind | None = None
) -> FloorTruth:
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
    return FloorTruth(
        ground,
        slope_rad=setup.floor.slope_sigma_rad * slope,
        across_rad=setup.floor.slope_sigma_rad * across,
        film_scale=1.0 + setup.floor.film_scale_sigma * scale,
        mass_scale=1.0 + setup.uncertainty.mass_sigma * mass,
        rolling_kg=max(rolling, 0.0),
        joint_sigma_rad=setup.uncertainty.joint_sigma_rad,
        servo=servo and servo.draws(1, int(rng.integers(2**31)))[0],
    )


def crawled_slopes(step: Step, slope_rad: float, across_rad: float) -> tuple[float, float]:
    """Return by what a floor rises ahead of a step's crawl, and by what it falls to its left.

    slope_rad, across_rad: by what it falls towards "there", and to the left of that way.
    """
    side = {"there": 1.0, "back": -1.0}.get(str(step.cells.get("way", "")), 0.0)
    return -side * slope_rad, side * across_rad


class SimulatedFloor:
    """Do each step of the procedure against a known truth; the same seed does the same.

    t_s: the lab's clock, with what a person takes.
    """

    def __init__(self, setup: Setup, truth: FloorTruth, seed: int = 0):
        self.truth, self.t_s = truth, 0.0
        self._setup, self._rng = setup, np.random.default_rng(seed)
        self.robot = truth.robot(setup.robot, self._rng)
        self.floor = Floor(self.robot, truth.slope_rad, 0.0, truth.across_rad)
        self._pose = [0.0] * (setup.robot.links - 1)

    def answer(self, step: Step, session: Session) -> Cells | None:
        """Do a step as a person would."""
        if step.kind == "straight":
            self.t_s += BEND_S
            self._pose = [0.0] * (self._setup.robot.links - 1)
            return {}
        if step.kind == "bend":
            return self._bend(step)
        if step.kind == "gait":
            return self._gait(step)
        if step.kind != "coast":
            raise BadInput(f"nobody on a floor can do a step of kind {step.kind}")
        return self.push(step)

    def look_again(
        self, step: Step, doubtful: Sequence[tuple[Field, tuple[float, float]]], cells: Cells
    ) -> Cells:
        """Leave what was measured as it is: a push is over."""
        return cells

    def _normal(self, sigma: float) -> float:
        return float(self._rng.normal()) * sigma

    def _bend(self, step: Step) -> Cells:
        self.t_s += BEND_S
        signs = balanced_signs(self._setup.robot.links)
        self._pose = pose_of(signs, math.radians(step.lambda_deg))
        scatter = math.sqrt(2) * self._setup.uncertainty.lambda_sigma_rad
        ends = [
            abs(told + self.robot.joint_error_rad[k]) + self._normal(scatter)
            for k, told in ((0, self._pose[0]), (-1, self._pose[-1]))
        ]
        return {"between_links_deg": round(180.0 - math.degrees(sum(ends) / 2), 1)}

    def push(self, step: Step, speed_m_s: float = SPEED) -> Cells | None:
        """Push until a push is as it should be; return its track, or way and time to rest."""
        for _ in range(TRIES):
            cells = self._once(step, speed_m_s * max(1.0 + self._normal(SPEED_SIGMA), 0.3))
            if cells is not None:
                return cells
        return None

    def _once(self, step: Step, speed_m_s: float) -> Cells | None:
        self.t_s += PUSH_S
        direction = 0.0 if step.cells["way"] == "there" else math.pi
        track = self.floor.push(
            self._pose,
            Push(
                speed_m_s,
                direction,
                self._normal(CROOKED_RAD),
                self._normal(SPIN_RAD_S),
                tail_first=step.cells.get("facing") == "back",
            ),
        )
        if self.truth.camera is None:
            way_m, time_s = to_rest(track, self._rng)
            return {
                "distance_m": way_m,
                "duration_s": time_s,
                "turned_deg": round(math.degrees(track.turned_rad)),
            }
        seen = film(track, replace(self.truth.camera, scale=self.truth.film_scale), self._rng)
        samples = np.stack([seen.t_s, seen.x_m, seen.y_m], axis=1)
        look = look_at(*samples.T)
        if look.doubts:
            return None
        return Tracked({**look.cells(), "by": "film"}, samples)

    def _gait(self, step: Step) -> Cells:
        gait = step.gait
        assert gait is not None  # a gait's step has one
        self.t_s += GAIT_S
        true = replace(gait, alpha_rad=gait.alpha_rad * self.truth.amplitude)
        slopes = crawled_slopes(step, self.truth.slope_rad, self.truth.across_rad)
        if self.truth.camera is not None:
            return self._filmed(gait, true, self.truth.camera, slopes)
        speed = crawl_speed(self.robot, true, slope_rad=slopes[0], across_rad=slopes[1])
        read, duration_s = timed_crawl(speed, self._setup.stopwatch, self._rng)
        self.t_s += duration_s
        return read

    def _filmed(
        self, gait: Gait, true: Gait, camera: Camera, slopes_rad: tuple[float, float]
    ) -> Cells:
        """Film a crawl, and measure the film: a scale and joints' gains are a little off."""
        self.t_s += RUN_S
        seen = replace(camera, scale=1.0 + self._normal(SPEED_OFF))
        rows = filmed_crawl(self.robot, true, seen, self._rng, *slopes_rad)
        rows[:, 4:] *= 1.0 + GAIN_OFF * self._rng.normal(size=rows.shape[1] - 4)
        return Tracked({**crawl_cells(rows, gait), "film_sha256": "simulated"}, rows, "video")
