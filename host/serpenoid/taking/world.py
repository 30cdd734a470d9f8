"""The lab of a session: what is true there, and nobody knows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..lab.instruments import Instrument
from ..lab.person import Display
from ..lab.recording import Camera
from ..lab.robot import LabRobot
from ..model.drives import Servo, ServoKind
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.settings import Setup

PHONE = Camera()


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

    def display(self, setup: Setup) -> Display:
        """Return the treadmill's display."""
        steps = setup.instruments
        return Display(
            steps.belt_speed_step_m_s,
            self.belt_scale,
            steps.belt_speed_least_m_s,
            setup.instruments.belt_speed_sigma_m_s,
        )

    def inclinometer_rad(self, setup: Setup) -> Instrument:
        """Return the inclinometer: its zero on top, in its steps."""
        step_rad = setup.instruments.incline_sigma_rad * math.sqrt(12)
        return Instrument(self.incline_zero_rad, step=step_rad)


def wheel_inertia_kg(setup: Setup, shape: float = 0.0) -> float:
    """Return J / r^2 of all wheels of a set-up, kg; shape: how far off the usual, in sigmas."""
    wheels_kg = setup.robot_table.wheels_kg
    if wheels_kg is not None:
        return max((0.75 + 0.15 * shape) * wheels_kg, 0.0)
    mass_kg = setup.robot.links * setup.robot.link_mass_kg
    return max((0.045 + 0.03 * shape) * mass_kg, 0.0)


def drawn_floor(
    setup: Setup, ground: Ground, rng: np.random.Generator, servo: ServoKind | None = None
) -> Truth:
    """Draw the errors that all readings on a floor share, as the set-up says they may be.

    servo: the kind of which the robot has one drawn; None: its joints follow the gait.
    """
    slope, scale, mass, shape, across = (float(v) for v in rng.normal(size=5))
    return Truth(
        ground,
        slope_rad=setup.instruments.floor_slope_sigma_rad * slope,
        across_rad=setup.instruments.floor_slope_sigma_rad * across,
        film_scale=1.0 + setup.instruments.film_scale_sigma * scale,
        mass_scale=1.0 + setup.instruments.mass_sigma * mass,
        rolling_kg=wheel_inertia_kg(setup, shape),
        joint_sigma_rad=setup.instruments.joint_sigma_rad,
        servo=servo and servo.draws(1, int(rng.integers(2**31)))[0],
    )
