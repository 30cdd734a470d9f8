"""The gait that costs least power at a given speed (the paper's Figs. 8-11, for any ground)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.checks import FORMULATIONS, check_choice, check_number
from ..base.errors import BadInput, NotConverged
from ..model.core_model import check_parts
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import steady_gait
from .finder import ANY, Finder, LeastPower
from .limits import GaitLimits
from .shapes import Array


def least_power_gait(
    robot: Robot,
    ground: Ground,
    *,
    speed_m_s: float,
    cost: str = "power",
    limits: GaitLimits = ANY,
    formulation: str = "explicit",
    joint_stiffness_n_m: float = 1e3,
    joint_damping_n_s_m: float = 1.0,
    rtol: float | None = None,
) -> LeastPower:
    """Find alpha, beta and omega that give a speed for the least mean power, over all shapes.

    For each shape the rate follows from the speed. A coarse table of shapes comes first. Its
    valleys are followed down, also along limits, and the lowest is searched again more closely. On
    a ratchet, waves from tail to head (beta below 0) are searched too.

    Parameters
    ----------
    robot, ground
        What crawls, and on what.
    speed_m_s
        The wanted speed, m/s.
    cost
        "power" (net; the paper's), "abs_power" or "positive_power" (servos do not regenerate).
    limits
        Of joints, servos and rate.
    formulation
        "explicit", or "implicit": the valleys of the exact model's table are followed by the
        paper's springs and dampers.
    joint_stiffness_n_m, joint_damping_n_s_m
        Of the implicit formulation, N/m and N s/m.
    rtol
        Accuracy of the final state, relative; 1e-10 on viscous and 1e-5 on dry ground unless given.

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
    springs = joint_stiffness_n_m, joint_damping_n_s_m
    (best,) = _front(robot, ground, [speed_m_s], cost, limits, rtol, formulation, springs)
    if isinstance(best, NotConverged):
        raise best
    return best


def power_front(
    robot: Robot,
    ground: Ground,
    *,
    speeds_m_s: Sequence[float] | Array,
    cost: str = "power",
    limits: GaitLimits = ANY,
    formulation: str = "explicit",
    joint_stiffness_n_m: float = 1e3,
    joint_damping_n_s_m: float = 1.0,
    rtol: float | None = None,
) -> tuple[LeastPower | None, ...]:
    """Find the least-power gait of every speed, in their order; None where no gait reaches it.

    Parameters
    ----------
    robot, ground, cost, limits, formulation
        As in `least_power_gait`.
    speeds_m_s
        The wanted speeds, m/s. One coarse table serves all. Each search also starts from the gaits
        of the next slower and faster speed; the answers depend neither on order nor on repeats.
    joint_stiffness_n_m, joint_damping_n_s_m
        Of the implicit formulation, N/m and N s/m.
    rtol
        Accuracy of the final states, relative.

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
    wanted = _wanted(speeds_m_s)
    speeds = sorted(set(wanted))
    springs = joint_stiffness_n_m, joint_damping_n_s_m
    front = _front(robot, ground, speeds, cost, limits, rtol, formulation, springs)
    by_speed = dict(zip(speeds, front, strict=True))
    return tuple(best if isinstance(best := by_speed[v], LeastPower) else None for v in wanted)


def _front(
    robot: Robot,
    ground: Ground,
    speeds: Sequence[float],
    cost: str,
    limits: GaitLimits,
    rtol: float | None,
    formulation: str,
    springs: tuple[float, float],
) -> list[LeastPower | NotConverged]:
    """Return the cheapest gait of each speed, in ascending order, or why there is none."""
    check_parts(robot, ground)
    check_choice("formulation", formulation, FORMULATIONS)
    soft = springs if formulation == "implicit" else None
    finders = [Finder(robot, on, speeds, cost, limits, rtol, soft) for on in directions(ground)]
    fronts = [one.front(speeds) for one in finders]
    return [cheaper(finders, optima) for optima in zip(*fronts, strict=True)]


def directions(ground: Ground) -> list[Ground]:
    """Return the ground, and on a ratchet also what the robot meets with its tail called head.

    A wave from tail to head is a wave from head to tail of the robot turned round. Without a
    ratchet that is the same robot.
    """
    return [ground, ground.turned_round()] if ground.ratchet else [ground]


def cheaper(
    finders: Sequence[Finder], optima: Sequence[LeastPower | NotConverged]
) -> LeastPower | NotConverged:
    """Return the cheapest gait of both directions of the wave, as the robot is to run it."""
    gaits = [(one, k) for k, one in enumerate(optima) if isinstance(one, LeastPower)]
    if not gaits:
        return optima[0]
    (best, turned), *others = sorted(gaits, key=lambda pair: pair[0].power_w)
    changes: dict[str, Any] = {
        "basins": sum(one.basins for one, _ in gaits),
        "runner_up_w": min(best.runner_up_w, *(one.power_w for one, _ in others), np.inf),
        "evaluations": sum(one.solved["states"] for one in finders),
    }
    if turned:
        gait = replace(best.gait, beta_rad=-best.gait.beta_rad)
        rtol = max(finders[0].rtol, 1e-6)
        ground = finders[0].ground
        changes |= {"gait": gait, "steady": steady_gait(finders[0].robot, ground, gait, rtol=rtol)}
    return replace(best, **changes)


def _wanted(speeds_m_s: Any) -> list[float]:
    """Return the wanted speeds as numbers; a front needs one at least."""
    speeds = np.asarray(speeds_m_s, dtype=object)
    if speeds.ndim != 1 or speeds.size == 0:
        raise BadInput(f"speeds_m_s is {speeds_m_s!r}; it must be a list of at least one speed")
    return [check_number("speed_m_s", speed, 0.0, open_low=True) for speed in speeds.tolist()]
