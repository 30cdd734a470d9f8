"""The lab of a session: what is true there and nobody knows, the robot, and what records it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..lab.crawl import crawl_speed, filmed_crawl
from ..lab.floor import Floor, Push, Track
from ..lab.instruments import Instrument
from ..lab.person import Display
from ..lab.recording import Camera, film, to_rest
from ..lab.robot import LabRobot, pose_of
from ..model.bends import bend_signs
from ..model.drives import Servo, ServoKind
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.settings import Setup
from ..session.track import Floats
from .steps import Step

PHONE = Camera()
RUN_M, RUN_S = 1.0, 40.0  # a gait run: so far, or so long at most
SPEED, SPEED_SIGMA = 0.9, 0.12  # m/s, of pushes, and how they scatter, relative
CROOKED_RAD, SPIN_RAD_S = 0.015, 0.06
SPEED_OFF, GAIN_OFF = 0.002, 0.002  # of a filmed crawl: its scale, each joint's amplitude


@dataclass(frozen=True)
class Truth:
    """What a person at a treadmill or on a floor does not know.

    Of the robot: ground, of the whole snake. mass_scale: its true mass over the one weighed.
    joint_sigma_rad: of what each joint stands off its set-point, for good. link_spread: relative,
    of each link's friction. rolling_kg, breakaway: of the wheels (`lab.robot`). amplitude: of the
    joints in a gait, true over commanded. servo: what moves them in a gait; None: they follow it.

    Of a treadmill: incline_zero_rad: what the inclinometer shows where it is level. belt_scale:
    true belt speed over shown. incline_scale: its true steps of grade over those stated.

    Of a floor: slope_rad, across_rad: by what it falls towards "there" and to the left of it.
    film_scale: lengths in films over true. camera: what films; None: tape and watch.

    Of the person: disturbance_m_s: of the robot when it is let go. misreads: share of readings that
    are typed wrong. hasty: share that are read too early. guided: between rails, which keep it
    straight. short_s: bent, it is filmed for so long while it drifts, instead of held; 0: it is
    held.
    """

    ground: Ground
    mass_scale: float = 1.0
    joint_sigma_rad: float = math.radians(0.5)
    link_spread: float = 0.0
    rolling_kg: float = 0.0
    breakaway: float = 1.0
    amplitude: float = 1.0
    servo: Servo | None = None
    incline_zero_rad: float = 0.0
    belt_scale: float = 1.0
    incline_scale: float = 1.0
    slope_rad: float = 0.0
    across_rad: float = 0.0
    film_scale: float = 1.0
    camera: Camera | None = PHONE
    disturbance_m_s: float = 0.03
    misreads: float = 0.0
    hasty: float = 0.0
    guided: bool = False
    short_s: float = 0.0

    def robot(self, body: Robot, rng: np.random.Generator) -> LabRobot:
        """Return the robot as it truly is, its joint errors drawn."""
        heavy = replace(
            body,
            link_mass_kg=body.link_mass_kg * self.mass_scale,
            link_inertia_kg_m2=body.inertia_kg_m2 * self.mass_scale,
        )
        whole = LabRobot.whole(
            heavy,
            self.ground,
            rolling_kg=self.rolling_kg,
            breakaway=self.breakaway,
            servo=self.servo,
        )
        return whole.drawn(rng, self.joint_sigma_rad, self.link_spread)

    def display(self, setup: Setup, scatter: float = 1.0) -> Display:
        """Return the treadmill's display; scatter: of the belt, over what the set-up states."""
        steps = setup.instruments
        return Display(
            steps.belt_speed_step_m_s,
            self.belt_scale,
            steps.belt_speed_least_m_s,
            scatter * setup.instruments.belt_speed_sigma_m_s,
        )

    def inclinometer_rad(self, setup: Setup) -> Instrument:
        """Return the inclinometer: its zero on top, in its steps."""
        step_rad = setup.instruments.incline_sigma_rad * math.sqrt(12)
        return Instrument(self.incline_zero_rad, step=step_rad)


def drawn_floor(
    setup: Setup, ground: Ground, rng: np.random.Generator, servo: ServoKind | None = None
) -> Truth:
    """Draw the errors that all readings on a floor share, as the set-up says they may be.

    servo: the kind of which the robot has one drawn; None: its joints follow the gait.
    """
    slope, scale, mass, shape, across = (float(v) for v in rng.normal(size=5))
    wheels_kg = setup.robot_table.wheels_kg
    mass_kg = setup.robot.links * setup.robot.link_mass_kg
    rolling = (
        (0.045 + 0.03 * shape) * mass_kg
        if wheels_kg is None
        else ((0.75 + 0.15 * shape) * wheels_kg)
    )
    return Truth(
        ground,
        slope_rad=setup.instruments.floor_slope_sigma_rad * slope,
        across_rad=setup.instruments.floor_slope_sigma_rad * across,
        film_scale=1.0 + setup.instruments.film_scale_sigma * scale,
        mass_scale=1.0 + setup.instruments.mass_sigma * mass,
        rolling_kg=max(rolling, 0.0),
        joint_sigma_rad=setup.instruments.joint_sigma_rad,
        servo=servo and servo.draws(1, int(rng.integers(2**31)))[0],
    )


class World:
    """A session's robot in the lab, and what camera, tape, watch and protractor record of it.

    robot_rng: draws the joints' errors; rng, for which it stands unless given, all else.
    """

    def __init__(
        self,
        setup: Setup,
        truth: Truth,
        rng: np.random.Generator,
        robot_rng: np.random.Generator | None = None,
    ):
        self.truth, self.rng = truth, rng
        self.setup = setup
        self.robot = truth.robot(setup.robot, robot_rng or rng)
        self._floor = Floor(self.robot, truth.slope_rad, truth.across_rad)
        self._speeds = dict[tuple[Gait, tuple[float, float]], float]()
        self.bend(0.0)

    def bend(self, bend_deg: float) -> list[float]:
        """Bend the robot, straight at 0; return what its joints are told."""
        signs = bend_signs(self.setup.plan.bend, self.setup.robot.links)
        self._pose_rad = pose_of(signs, math.radians(bend_deg))
        return self._pose_rad

    def protractor_deg(self, scatter: float = 1.0) -> list[float]:
        """Return what a protractor shows between the links at tail and head.

        scatter: of each, over what the set-up states of a bend.
        """
        off_rad = scatter * self.setup.instruments.lambda_sigma_rad
        return self.robot.protractor_deg(self._pose_rad, off_rad, self.rng)

    def normal(self, sigma: float) -> float:
        """Return an error drawn."""
        return float(self.rng.normal()) * sigma

    def push(self, step: Step, speed_m_s: float = SPEED) -> Track:
        """Push the robot the way that a step says, as a hand does: about so fast, not straight."""
        direction = 0.0 if step.cells["way"] == "there" else math.pi
        speed_m_s *= max(1.0 + self.normal(SPEED_SIGMA), 0.3)
        crooked_rad, spin_rad_s = self.normal(CROOKED_RAD), self.normal(SPIN_RAD_S)
        made = Push(speed_m_s, direction, crooked_rad, spin_rad_s)
        return self._floor.push(self._pose_rad, made)

    def film(self, track: Track, camera: Camera = PHONE) -> Floats:
        """Return what a film shows of a push: t_s, x_m, y_m in rows."""
        return film(track, replace(camera, scale=self.truth.film_scale), self.rng)[:, :3]

    def tape(self, track: Track) -> dict[str, float]:
        """Return what tape and watch say of a push, and by how much it turned."""
        way_m, time_s = to_rest(track, self.rng)
        turned_deg = round(math.degrees(track.turned_rad))
        return {"distance_m": way_m, "duration_s": time_s, "turned_deg": turned_deg}

    def time_crawl(self, step: Step, gait: Gait) -> tuple[dict[str, float], float]:
        """Return what tape and watch say of a step's crawl, and how long it took, s."""
        key = gait, self._slopes(step)
        if key not in self._speeds:
            rises, falls = key[1]
            self._speeds[key] = crawl_speed(
                self.robot, self._made(gait), slope_rad=rises, across_rad=falls
            )
        speed_m_s, watch = self._speeds[key], self.setup.instruments
        distance = min(RUN_M, speed_m_s * RUN_S)
        duration = distance / speed_m_s if speed_m_s > 0.0 else RUN_S
        duration += self.normal(watch.time_sigma_s)
        measured = max(distance + self.normal(watch.distance_sigma_m), 0.0)
        read = {"distance_m": round(measured, 3), "duration_s": round(max(duration, 0.1), 2)}
        return read, duration

    def film_crawl(self, step: Step, gait: Gait, camera: Camera = PHONE) -> Floats:
        """Return what is measured in a film of a crawl, its scale and joints' gains a little off.

        Rows as of `filmed_crawl`.
        """
        off = replace(camera, scale=1.0 + self.normal(SPEED_OFF))
        rows = filmed_crawl(self.robot, self._made(gait), off, self.rng, *self._slopes(step))
        rows[:, 4:] *= 1.0 + GAIN_OFF * self.rng.normal(size=rows.shape[1] - 4)
        return rows

    def _made(self, gait: Gait) -> Gait:
        return replace(gait, alpha_rad=gait.alpha_rad * self.truth.amplitude)

    def _slopes(self, step: Step) -> tuple[float, float]:
        """Return by what the floor rises ahead of a step's crawl, and falls to its left."""
        side = {"there": 1.0, "back": -1.0}.get(str(step.cells.get("way", "")), 0.0)
        return -side * self.truth.slope_rad, side * self.truth.across_rad
