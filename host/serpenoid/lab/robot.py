"""The robot in the lab: what is true of it and nobody there knows, as the core's chain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .. import _core
from ..base.errors import NotConverged
from ..model.bends import joint_multiples
from ..model.core_model import friction_numbers
from ..model.drives import Servo, core_servo
from ..model.ground import Ground
from ..model.robot import Robot


@dataclass(frozen=True)
class LabRobot:
    """Hold a robot's truth.

    body: masses, lengths and inertias. grounds: friction of each link, from the tail; one for all
    links stands for each. joint_error_rad: what each joint stands off its set-point, the same in
    every pose. rolling_kg: J / r^2 of all wheels together, which their turning adds to the mass
    along the links. breakaway: dry force at rest over the one in motion, 1 or more. servo: what
    moves the joints in a gait; None: they follow it.
    """

    body: Robot
    grounds: tuple[Ground, ...]
    joint_error_rad: tuple[float, ...] | float = 0.0
    rolling_kg: float = 0.0
    breakaway: float = 1.0
    servo: Servo | None = None

    @property
    def _links(self) -> tuple[Ground, ...]:
        return self.grounds * (self.body.links // len(self.grounds))

    @classmethod
    def whole_body(cls, body: Robot, ground: Ground, **more: Any) -> LabRobot:
        """Return a robot whose links share the whole snake's friction alike."""
        link_ground = Ground.whole_body(body.links, ground.ct, ground.cn, ground.ft0, ground.fn0)
        return cls(body, (link_ground,), **more)

    def drawn(
        self, rng: np.random.Generator, joint_sigma_rad: float, link_spread: float = 0.0
    ) -> LabRobot:
        """Return this robot with joint errors of its own, and links that differ by a spread.

        The sum of all links' friction stays what it is.
        """
        joints = tuple(rng.normal(size=self.body.links - 1) * joint_sigma_rad)
        factors = np.maximum(1.0 + link_spread * rng.normal(size=(self.body.links, 4)), 0.2)
        factors /= factors.mean(axis=0)
        grounds = tuple(g.scaled(*map(float, f)) for g, f in zip(self._links, factors, strict=True))
        return replace(self, grounds=grounds, joint_error_rad=joints)

    def chain(self, servo: Servo | None = None) -> _core.LabChain:
        """Return the robot as a body that can be moved, straight but for its joints' errors.

        servo: what moves its joints; None: they are led.
        """
        body, share = self.body, self.rolling_kg / self.body.links
        rows = [[*friction_numbers(g), share, self.breakaway] for g in self._links]
        chain = _core.LabChain(
            body.link_mass_kg,
            body.link_length_m,
            body.inertia_kg_m2,
            np.array(rows),
            servo and core_servo(servo),
        )
        chain.set_joints(self.true_joints([0.0] * (body.links - 1)))
        return chain

    def true_joints(self, set_rad: Sequence[float]) -> list[float]:
        """Return where the joints stand when they are told to stand there."""
        return np.add(set_rad, self.joint_error_rad).tolist()

    def protractor_deg(
        self, set_rad: Sequence[float], scatter_rad: float, rng: np.random.Generator
    ) -> list[float]:
        """Return what a protractor shows between the links at tail and head, each off by this."""
        true = self.true_joints(set_rad)
        ends_rad = [abs(true[k]) + scatter_rad * float(rng.normal()) for k in (0, -1)]
        return [180.0 - math.degrees(end_rad) for end_rad in ends_rad]


def check_answer(solved: bool) -> None:
    """Raise NotConverged where the core came to no answer."""
    if not solved:
        raise NotConverged("the model came to no answer; are robot and friction sensible?")


def pose_of(signs: Sequence[int], angle_rad: float) -> list[float]:
    """Return the joints' set-points, rad, of links at signs times an angle to the robot's axis."""
    return [k * angle_rad for k in joint_multiples(tuple(signs))]
