"""What may be wrong about a robot: friction, amplitudes and phases of its joints, as samples."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from ..model.checks import check_number
from ..model.drives import Servo, ServoKind
from ..model.errors import BadInput
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot

FRICTION = ("ct", "cn", "ft0", "fn0")
# How the errors of the four hang together after a session with one bend of 7.5 deg.
_AFTER_A_SESSION = np.array(
    [
        [1.0, -0.65, -0.32, 0.58],
        [-0.65, 1.0, 0.21, -0.57],
        [-0.32, 0.21, 1.0, -0.21],
        [0.58, -0.57, -0.21, 1.0],
    ]
)


@dataclass(frozen=True)
class Uncertainty:
    """State how well friction and servos are known; one standard deviation each.

    Attributes
    ----------
    friction
        Relative sigmas of ct, cn, ft0, fn0 (log-normal); by default those of a session with one
        bend of 7.5 deg.
    grounds
        Frictions sampled elsewhere, such as by a session's fit; they replace `friction`.
    amplitude, common_amplitude
        Of the joints' amplitude, relative: of each joint on its own, and of all together.
    lag_rad
        Of each joint's phase on its own, rad. A lag that all joints share changes nothing.
    correlated
        Whether frictions have the correlations of that session.
    joint_gain, joint_shift_rad
        Measured factors of amplitude and phase shifts, rad, one a joint, in place of 1 and 0.
    servo
        The kind of servo that moves the joints, drawn anew for each sample; None: joints follow
        what is told them, but for the errors above.

    Raises
    ------
    BadInput
        For values out of range.

    Examples
    --------
    >>> doubt = sn.Uncertainty(amplitude=0.01)  # each joint's amplitude, 1 %
    >>> doubt.friction
    (0.06, 0.35, 0.06, 0.13)
    """

    friction: tuple[float, float, float, float] = (0.06, 0.35, 0.06, 0.13)
    grounds: tuple[Ground, ...] = ()
    amplitude: float = 0.02
    common_amplitude: float = 0.03
    lag_rad: float = math.radians(1.0)
    correlated: bool = True
    joint_gain: tuple[float, ...] = ()
    joint_shift_rad: tuple[float, ...] = ()
    servo: ServoKind | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.friction, Collection) or len(self.friction) != len(FRICTION):
            raise BadInput(f"friction is {self.friction!r}; it must be four sigmas, {FRICTION}")
        for name, value in zip(FRICTION, self.friction, strict=True):
            check_number(f"friction, {name}", value, 0.0, 3.0)
        for name, most in (("amplitude", 0.5), ("common_amplitude", 0.5), ("lag_rad", 1.0)):
            check_number(name, getattr(self, name), 0.0, most)

    def samples(
        self, robot: Robot, ground: Ground, count: int, seed: int = 2005, skip: int = 0
    ) -> list[Sample]:
        """Draw robots that may be the real one: scrambled Sobol points, the same for a seed.

        skip: so many of `grounds` are passed over, as far as there are others.
        """
        from scipy.stats import norm, qmc

        joints = robot.links - 1
        sobol = qmc.Sobol(5 + 2 * joints, seed=seed)  # pyright: ignore[reportCallIssue]
        cube = sobol.random_base2((count - 1).bit_length())[:count]
        points = norm.ppf(np.clip(cube, 1e-9, 1 - 1e-9))
        if self.grounds:
            pick = np.random.default_rng(2005).permutation(len(self.grounds))
            grounds = [self.grounds[pick[(skip + i) % pick.size]] for i in range(count)]
        else:
            mix = np.linalg.cholesky(_AFTER_A_SESSION) if self.correlated else np.eye(4)
            factors = np.exp(points[:, :4] @ mix.T * np.array(self.friction))
            grounds = [ground.scaled(*row) for row in factors.tolist()]
        seen = np.array(self.joint_gain or [1.0] * joints)
        late = np.array(self.joint_shift_rad or [0.0] * joints)
        for name, values in (("joint_gain", seen), ("joint_shift_rad", late)):
            if len(values) != joints:
                raise BadInput(f"{name} has {len(values)} values; the robot has {joints} joints")
        gains = seen * (1 + self.common_amplitude * points[:, 4:5])
        gains = np.clip(gains + self.amplitude * points[:, 5 : 5 + joints], 0.0, 2.0)
        shifts = late + self.lag_rad * points[:, 5 + joints :]
        servos = self._servos(count, seed)
        return [
            Sample(ground, tuple(gain), tuple(shift), servo)
            for ground, gain, shift, servo in zip(
                grounds, gains.tolist(), shifts.tolist(), servos, strict=True
            )
        ]

    def _servos(self, count: int, seed: int) -> list[Servo] | list[None]:
        """Return a servo for each sample."""
        if self.servo is None:
            return [None] * count
        return [self.servo.servo] * count if self.servo.exact else self.servo.draws(count, seed)

    def in_words(self) -> str:
        """Return the statement in one line."""
        friction = (
            f"{len(self.grounds)} sampled frictions"
            if self.grounds
            else ", ".join(
                f"{n} ± {100 * s:.3g} %" for n, s in zip(FRICTION, self.friction, strict=True)
            )
        )
        return (
            f"{friction}; amplitude ± {100 * self.common_amplitude:.3g} % common and "
            f"± {100 * self.amplitude:.3g} % of each joint; phase ± "
            f"{math.degrees(self.lag_rad):.3g} deg of each joint; servos: "
            f"{'ideal' if self.servo is None else self.servo.name}"
        )


@dataclass(frozen=True, slots=True)
class Sample:
    """Hold one robot that may be the real one: its ground, and what its joints make of a gait."""

    ground: Ground
    joint_gain: tuple[float, ...]
    joint_shift_rad: tuple[float, ...]
    servo: Servo | None = None

    def gait(self, gait: Gait) -> Gait:
        """Return what the joints do when they are told to do a gait."""
        return replace(gait, joint_gain=self.joint_gain, joint_shift_rad=self.joint_shift_rad)

    def turned_round(self) -> Sample:
        """Return the same robot with its tail called head; it runs the gait with beta negated."""
        return Sample(
            self.ground.turned_round(),
            self.joint_gain[::-1],
            self.joint_shift_rad[::-1],
            self.servo,
        )
