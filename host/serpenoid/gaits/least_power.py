"""The gait that costs least power at a given speed (the paper's Figs. 8-11, for any ground)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..model.checks import check_number
from ..model.errors import BadInput, NotConverged
from ..model.ground import Ground
from ..model.robot import Robot
from .finder import ANY, Finder, LeastPower, finder
from .gait_table import Candidate
from .limits import GaitLimits
from .quadratic_search import Array
from .shape_search import GaitShape, exact_solver


class EitherWave:
    """Finds the cheapest gaits with waves in one direction and, on a ratchet, in both.

    A wave from tail to head is a wave from head to tail of the robot turned round. Without a
    ratchet that is the same robot. Each search also starts from the gait of the speed before.
    watts: what each search found last, inf for nothing.
    """

    def __init__(self, ground: Ground, search: Callable[[Ground], Finder]) -> None:
        self.ground = ground
        self.searches = [search(ground)]
        if ground.ratchet:
            self.searches.append(search(ground.turned_round()))
        self.starts: list[Candidate | None] = [None] * len(self.searches)
        self.watts = [math.inf] * len(self.searches)

    def minimize(self, speed: float) -> LeastPower:
        """Return the cheapest gait for a speed; raises NotConverged."""
        found: list[LeastPower] = []
        lost: NotConverged | None = None
        for k, search in enumerate(self.searches):
            self.watts[k] = math.inf
            try:
                one = search.minimize(speed, self.starts[k])
            except NotConverged as error:
                lost = lost or error
                continue
            gait, self.watts[k] = one.gait, one.power_w
            shape = GaitShape.of(gait.alpha_rad, gait.beta_rad)
            self.starts[k] = Candidate(0.0, shape, gait.omega_rad_s)
            found.append(one if k == 0 else self._turned_back(one, search))
        if not found:
            raise lost or NotConverged(f"no gait reaches {speed:g} m/s")
        best, *others = sorted(found, key=lambda one: one.power_w)
        return replace(
            best,
            basins=sum(one.basins for one in found),
            runner_up_w=min(best.runner_up_w, *(one.power_w for one in others), math.inf),
            evaluations=sum(one.evaluations for one in found),
        )

    def _turned_back(self, found: LeastPower, search: Finder) -> LeastPower:
        """Return the gait as it is for the robot that has its head in front."""
        gait = replace(found.gait, beta_rad=-found.gait.beta_rad)
        rtol = max(search.rtol, 1e-6)
        steady = exact_solver(search.robot, self.ground, powers=True)(gait, rtol)
        return replace(found, gait=gait, steady=steady)


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

    A coarse table of shapes and rates comes first. Quadratic models then follow every valley that
    may hold the minimum; the rate is solved for the speed. On a ratchet, waves from tail to head
    (beta below 0) are searched too.

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
        The gait, its power and the error of the minimum.

    Raises
    ------
    BadInput
        For arguments out of range, and wheels without any rolling friction.
    NotConverged
        If no gait reaches the speed; the message names the fastest one.
    """

    def search(on: Ground) -> Finder:
        return finder(
            robot, on, [speed_m_s], cost, limits, rtol, formulation, joint_stiffness_n_m,
            joint_damping_n_s_m,
        )  # fmt: skip

    return replace(EitherWave(ground, search).minimize(float(speed_m_s)), formulation=formulation)


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
        The wanted speeds, m/s. One coarse table serves all. Each search also starts from the gait
        of the next lower speed, so the answers depend neither on their order nor on repeats.
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
    """
    speeds = _wanted(speeds_m_s)

    def search(on: Ground) -> Finder:
        return finder(
            robot, on, speeds, cost, limits, rtol, formulation, joint_stiffness_n_m,
            joint_damping_n_s_m,
        )  # fmt: skip

    waves = EitherWave(ground, search)
    found: dict[float, LeastPower | None] = {}
    for speed in sorted(set(speeds)):
        try:
            found[speed] = replace(waves.minimize(speed), formulation=formulation)
        except NotConverged:
            found[speed] = None
    return tuple(found[speed] for speed in speeds)


def _wanted(speeds_m_s: Any) -> list[float]:
    """Return the wanted speeds as numbers; a front needs one at least."""
    speeds = np.asarray(speeds_m_s, dtype=object)
    if speeds.ndim != 1 or speeds.size == 0:
        raise BadInput(f"speeds_m_s is {speeds_m_s!r}; it must be a list of at least one speed")
    return [check_number("speed_m_s", speed, 0.0, open_low=True) for speed in speeds.tolist()]
