"""The gait that costs least power at a given speed (the paper's Figs. 8-11, for any ground)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.checks import check_choice, check_number
from ..base.errors import BadInput, NotConverged
from ..base.rows import Result, Row, detail, two_digits
from ..base.vectors import Array
from ..model.core_model import check_parts
from ..model.gait import Gait, gait_name
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, check_ground, steady_gait
from .limits import GaitLimits, SpeedLosses, speed_losses
from .search import COSTS, FINE_RTOL, ON_LIMIT, SMOOTH_RTOL, Point, Search

PAPER_LIMITS, NO_LOSSES = GaitLimits(), SpeedLosses(math.nan, math.nan)


@dataclass(frozen=True, slots=True)
class LeastPower(Result):
    """Hold the gait with the least power for a speed.

    Attributes
    ----------
    gait
        The gait found.
    power_w
        The cost that was minimized, W.
    speed_m_s
        Its speed, m/s.
    cost
        "power", "abs_power" or "positive_power".
    steady
        The exact model's periodic state.
    formulation
        "explicit" or "implicit".
    limits
        The limits of the search.
    active
        Those limits that the gait has reached, in words.
    power_error_w
        How much less power there may be, W: solved_error_w, the accuracy with which the search
        compares gaits, and what its last two restarts gained.
    solved_error_w
        Error of this gait's power, W.
    losses
        Shares of the speed that are lost with less amplitude, and with less friction across.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> best = sn.least_power_gait(robot, ground, speed_m_s=0.1)
    >>> round(best.gait.omega_rad_s, 1)
    1.8
    """

    gait: Gait
    power_w: float
    speed_m_s: float
    cost: str
    steady: Steady
    formulation: str = "explicit"
    limits: GaitLimits = PAPER_LIMITS
    active: tuple[str, ...] = ()
    power_error_w: float = 0.0
    solved_error_w: float = 0.0
    losses: SpeedLosses = NO_LOSSES

    def in_words(self) -> str:
        """Return the gait, its power and what it loses, in the words of a builder."""
        alpha, beta = math.degrees(self.gait.alpha_rad), math.degrees(self.gait.beta_rad)
        frequency_hz = two_digits(self.gait.omega_rad_s / math.tau)
        return (
            f"The gait of least power: {alpha:.0f}°/{beta:.0f}° at {frequency_hz} Hz, "
            f"{two_digits(self.power_w)} W. It loses {self.losses.in_words()}."
        )

    def rows(self) -> list[Row]:
        """Return power, speed, limits reached, losses, and what the search may have missed."""
        return [
            Row(f"least {self.cost}", "W", self.power_w),
            *self.steady.rows(),
            Row("limits reached", "", words=", ".join(self.active) or "none"),
            *self.losses.rows(),
            detail("some gait may need less, by", "W", self.power_error_w),
        ]


def least_power_gait(
    robot: Robot,
    ground: Ground,
    *,
    speed_m_s: float,
    cost: str = "power",
    limits: GaitLimits = PAPER_LIMITS,
    formulation: str = "explicit",
    joint_stiffness_n_m: float = 1e3,
    joint_damping_n_s_m: float = 1.0,
    rtol: float | None = None,
) -> LeastPower:
    """Find alpha, beta and omega that give a speed for the least mean power, over all shapes.

    For each shape the rate follows from the speed. A coarse table of shapes comes first. From its
    cheapest ones the Nelder-Mead method goes down, also along limits, and starts again at the best.

    Parameters
    ----------
    robot
        What crawls.
    ground
        Friction of what it crawls on. Friction along the links must be the same both ways.
    speed_m_s
        The wanted speed, m/s.
    cost
        "power" (net; the paper's), "abs_power" or "positive_power" (servos do not regenerate).
    limits
        Of joints, servos, rate and of the speed that is lost with less amplitude or friction.
    formulation
        "explicit", or "implicit": the paper's springs and dampers, from the exact model's optimum.
    joint_stiffness_n_m
        Stiffness of the springs in the joints, N/m.
    joint_damping_n_s_m
        Damping in the joints, N s/m.
    rtol
        Accuracy of the final state, relative; 1e-10 on viscous and 1e-6 on dry ground unless given.

    Returns
    -------
    LeastPower
        The gait of ideal joints, its power and the error of the minimum.

    Raises
    ------
    BadInput
        For arguments out of range, and wheels without any rolling friction.
    NotConverged
        If no gait reaches the speed; the message names the fastest one.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> best = sn.least_power_gait(robot, ground, speed_m_s=0.1)
    >>> round(1e3 * best.power_w, 2)
    7.64
    """
    check_parts(robot, ground)
    check_choice("formulation", formulation)
    check_choice("cost", cost, COSTS)
    _check_speed(robot, speed_m_s)
    _check_friction(ground)
    springs = (joint_stiffness_n_m, joint_damping_n_s_m) if formulation == "implicit" else None
    search = Search(robot, ground, speed_m_s, cost, limits, springs)
    if rtol is None:
        # The answer's net power on viscous ground is known to 1e-10, that by springs to 1e-4.
        exact = 1e-10 if cost == "power" else SMOOTH_RTOL
        rtol = 1e-4 if springs else exact if ground.smooth else 0.1 * FINE_RTOL
    check_ground(ground, rtol)
    pair = 2
    if robot.links <= pair:
        raise NotConverged(
            "no gait travels at all: of two links' one joint a stroke undoes the one before it; "
            "take three links or more"
        )
    cheapest = search.best()
    answer = None if cheapest is None else _finished(search, *cheapest, rtol)
    if answer is None:
        raise NotConverged(_unreachable(search))
    return answer


def power_front(
    robot: Robot, ground: Ground, *, speeds_m_s: Sequence[float] | Array, **search: Any
) -> tuple[LeastPower | None, ...]:
    """Find the least-power gait of every speed, in their order; None where no gait reaches it.

    Parameters
    ----------
    robot
        What crawls.
    ground
        Friction of what it crawls on.
    speeds_m_s
        The wanted speeds, m/s.
    search
        As in `least_power_gait`.

    Returns
    -------
    tuple of LeastPower or None
        One for each speed.

    Raises
    ------
    BadInput
        For arguments out of range.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> front = sn.power_front(robot, ground, speeds_m_s=[0.05, 0.1])
    >>> [round(1e3 * best.power_w, 1) for best in front]
    [1.9, 7.6]
    """
    speeds = np.asarray(speeds_m_s, dtype=object)
    if speeds.ndim != 1 or speeds.size == 0:
        raise BadInput(f"speeds_m_s is {speeds_m_s!r}; it must be a list of at least one speed")
    for speed in speeds.tolist():
        _check_speed(robot, speed)
    front: list[LeastPower | None] = []
    for speed in speeds.tolist():
        try:
            front.append(least_power_gait(robot, ground, speed_m_s=speed, **search))
        except NotConverged:
            front.append(None)
    return tuple(front)


def _check_speed(robot: Robot, speed_m_s: float) -> None:
    """Refuse a speed that no snake robot makes, for which a search would take minutes.

    From a millionth of its body's length a second, as on dry ground states of slower gaits drown in
    rounding, to a hundred lengths.
    """
    check_number("speed_m_s", speed_m_s, 1e-6 * robot.body_length_m, 100 * robot.body_length_m)


def _check_friction(ground: Ground) -> None:
    """Refuse ratchet wheels, and wheels without rolling friction that grip dryly.

    The latter follow the wave as a train follows its rails, at omega link_length_m / beta however
    small alpha is, and no friction does any work.
    """
    if ground.ratchet:
        raise BadInput(
            "ground has different friction forwards and backwards; the search takes wheels that "
            "roll alike both ways"
        )
    if ground.ct_forward == ground.ft0_forward == 0.0 < ground.fn0:
        raise BadInput(
            "ct and ft0 are both 0: the wheels roll for nothing, and fn0 holds them sideways. The "
            "less the joints bend, the less power it takes, so no gait takes least; give the "
            "measured ct or ft0, even if it is small"
        )


def _finished(search: Search, best: Point, gain: float, rtol: float) -> LeastPower | None:
    """Return the answer, solved once more to rtol; None for a gait beyond a limit or too slow.

    gain: of the search's last restarts, e-folds of cost.
    """
    assert best.gait is not None
    tried = search.rates(best.gait, rtol)
    if not tried or best.margin < -ON_LIMIT:
        return None
    log_rate, _, state = tried[0]
    gait = replace(best.gait, omega_rad_s=math.exp(log_rate))
    miss, largest_miss = abs(state.speed_m_s / search.speed_m_s - 1), 1e-2
    if not miss < largest_miss:  # the rough states were wrong
        return None
    robot, ground, watts = search.robot, search.ground, search.watts(state)
    numerical = getattr(state, f"{search.cost}_error_w") + 2 * state.error_estimate * watts
    exact = state
    if search.springs is not None or search.cost == "power":  # which was solved without the others
        exact_rtol = max(rtol, SMOOTH_RTOL if search.springs is None else 1e-6)
        exact = steady_gait(robot, ground, gait, rtol=exact_rtol)
    losses = speed_losses(robot, ground, gait)
    # The power of a state is known to ten times what its speed is.
    shapes_rtol = 10 * search.accuracy[0]  # tolerance to which the search knows powers
    # Power rises at most with about the third power of speed.
    unknown = gain + shapes_rtol + 3 * miss
    return LeastPower(
        gait,
        watts,
        state.speed_m_s,
        search.cost,
        exact,
        "explicit" if search.springs is None else "implicit",
        limits=search.limits,
        active=search.limits.active(gait, search.torque_nm(gait), 1 - losses.worst),
        power_error_w=numerical + watts * min(unknown, 1.0),
        solved_error_w=numerical,
        losses=losses,
    )


def _unreachable(search: Search) -> str:
    """Return how fast the robot can go within the limits, and what to do."""
    within = f"within the limits ({search.limits.in_words()})"
    fastest, unit_m_s = search.fastest(), search.robot.body_length_m
    gait = None if fastest is None else fastest.gait
    speed_m_s = 0.0 if fastest is None else search.speed_m_s * math.exp(-fastest.log_cost)
    # Less than 1e-9 body lengths a radian of the gait is rounding.
    if gait is None or speed_m_s < 1e-9 * unit_m_s * gait.omega_rad_s:
        return (
            f"no gait travels at all {within}: ask for wider limits; three links and friction that "
            "is greater across them than along them are needed, too"
        )
    name = f"{gait_name(gait)}, makes {speed_m_s:.3g} m/s"
    if speed_m_s >= search.speed_m_s:
        return (
            f"no gait of {search.speed_m_s:g} m/s was found {within}, though one, {name}, whatever "
            "the torque; ask for a wider range of rates or more torque"
        )
    model = " by the exact model" if search.springs else ""
    return (
        f"no gait reaches {search.speed_m_s:g} m/s {within}; the fastest found{model}, {name}; ask "
        "for less speed, or wider limits"
    )
