"""From a friction fit to predicted speeds (Fig. 17) by both formulations, with their errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.long_calls import in_threads
from ..friction.result import FrictionFit
from ..model.drives import ServoKind
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, steady_gait
from ..servos.catalogue import HOBBY
from ..servos.speed_limit import highest_hz
from ..simulation.run import Run
from ..simulation.scene import Scene
from ..simulation.simulate import simulate
from ..simulation.steady_springs import steady_springs
from .band import speed_band
from .speeds import Progress

STIFFNESS_N_M, DAMPING_N_S_M = 1000.0, 1.0  # the paper's
SPRINGS_RTOL = 1e-3

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SpeedPoint:
    """Hold the speeds predicted for one rate.

    explicit_m_s: periodic state of the exact model, explicit_error_m_s: its numerical error;
    low_m_s, high_m_s: 95 % interval of the speed that friction fit, joints and servos leave
    (`SpeedBand`); low_ideal_m_s, high_ideal_m_s: without the servos. servo_m_s: with the typical
    servo; highest_hz: the frequency up to which such a gait is not too fast for it; beyond,
    low_m_s and high_m_s are NaN.
    implicit_m_s: periodic state of the implicit model with the paper's springs, run until it
    repeats; implicit_error_m_s: what cycles and time steps leave open
    in it.
    """

    frequency_hz: float
    explicit_m_s: float
    explicit_error_m_s: float
    low_m_s: float
    high_m_s: float
    low_ideal_m_s: float
    high_ideal_m_s: float
    implicit_m_s: float
    implicit_error_m_s: float
    settling_time_s: float
    servo_m_s: float
    highest_hz: float

    @property
    def follows(self) -> bool:
        """Return whether the gait is not too fast for typical servos."""
        return self.frequency_hz <= self.highest_hz

    def to_dict(self) -> dict[str, float]:
        """Return the figures by name."""
        return {name: getattr(self, name) for name in self.__slots__}


def predict(
    robot: Robot, fit: FrictionFit, gait: Gait, servo: ServoKind | None = HOBBY
) -> SpeedPoint:
    """Predict the speed of one gait on fitted ground, with what fit and servos leave uncertain.

    servo: the kind that moves the joints, any hobby servo unless given; None: they follow the gait.
    The uncertainty is that of sampled frictions, not of a tangent: where wheels stick, the speed
    hangs on friction only once it is weak enough for them to slip.
    """
    s = steady_gait(robot, fit.ground, gait, powers=False)
    band = speed_band(fit, gait, servo=servo)
    springs = steady_springs(
        robot,
        fit.ground,
        gait,
        joint_stiffness_n_m=STIFFNESS_N_M,
        joint_damping_n_s_m=DAMPING_N_S_M,
        rtol=SPRINGS_RTOL,
    )
    return SpeedPoint(
        frequency_hz=gait.omega_rad_s / (2 * math.pi),
        explicit_m_s=s.speed_m_s,
        explicit_error_m_s=s.error_estimate * s.speed_m_s,
        low_m_s=band.low_m_s,
        high_m_s=band.high_m_s,
        low_ideal_m_s=band.low_joints_m_s,
        high_ideal_m_s=band.high_joints_m_s,
        implicit_m_s=springs.speed_m_s,
        implicit_error_m_s=springs.error_estimate * springs.speed_m_s,
        settling_time_s=s.settling_time_s,
        servo_m_s=band.speed_m_s,
        highest_hz=math.inf if servo is None else highest_hz(gait, servo),
    )


def predict_all(
    robot: Robot,
    fit: FrictionFit,
    gaits: Sequence[Gait],
    *,
    servo: ServoKind | None = HOBBY,
    progress: Progress | None = None,
) -> list[SpeedPoint]:
    """Predict every gait of a list as `predict` does; progress is called with 1 after each."""
    return in_threads(lambda gait: predict(robot, fit, gait, servo), gaits, progress)


def one_cycle(robot: Robot, ground: Ground, gait: Gait, cycles: int = 3) -> tuple[Steady, Run]:
    """Return the periodic state and a run of it over some cycles, for pictures of the path."""
    s = steady_gait(robot, ground, gait)
    run = simulate(
        Scene(
            robot,
            ground,
            gait,
            start="steady",
            dt_s=gait.period_s / 600,
            record_every=5,
            method="rk4" if ground.smooth else "nonsmooth",
            duration_s=cycles * gait.period_s,
        )
    )
    return s, run
