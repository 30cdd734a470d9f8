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
from .finder import ANY, RADIUS_KNOWN, Finder, LeastPower, finder
from .gait_table import Optimum, led
from .limits import GaitLimits
from .quadratic_search import Array
from .shape_search import Candidate, GaitShape, exact_solver

_STILL, _FAR_LED = 0.03, 0.3  # e-folds of shape: an optimum that moves so much is led on
_JOINS = 0.05  # e-folds of shape: tangents that lead so near to one another
_ABOVE = 1e-2  # e-folds of power over its neighbours' line: such a speed is searched anew


class _Track:
    """The optima of the last speeds, and where they lead."""

    def __init__(self) -> None:
        self._known: list[Optimum] = []
        self._led = np.full(3, np.inf)  # where the last optimum was expected
        self._missed = 0.0  # by so much of swing or lag, where tangents led

    def add(self, best: Optimum) -> None:
        """Keep an optimum."""
        self._known.append(best)
        missed = float(np.abs(self._led - best.at)[:2].max())
        self._missed = missed if math.isfinite(missed) else 0.0

    def only(self, speed_m_s: float) -> _Track:
        """Return a track that knows the optimum of one speed alone, if it was found."""
        track = _Track()
        track._known = [one for one in self._known if one.log_speed == math.log(speed_m_s)]
        return track

    def joins(self, speed_m_s: float, other: float) -> bool:
        """Tell whether the tangents at two speeds show that one valley holds both optima."""
        known = {one.log_speed: one for one in self._known}
        first, second = (known.get(math.log(v)) for v in (speed_m_s, other))
        if not (first and second) or first.tangent is None or second.tangent is None:
            return False
        move = (second.log_speed - first.log_speed) * (first.tangent + second.tangent) / 2
        return bool(np.abs(second.at - first.at - move)[:2].max() < _JOINS)

    def expected(self, speed_m_s: float) -> tuple[list[Candidate], float]:
        """Return where the optimum should be, and how far off, e-folds of shape.

        Where no tangent leads: the last, and the end of the line through the last two.
        """
        if not self._known:
            return [], RADIUS_KNOWN
        last, x = self._known[-1], math.log(speed_m_s)
        at, radius = last.at + np.array([0.0, 0.0, x - last.log_speed]), RADIUS_KNOWN
        self._led = np.full(3, np.inf)
        found = led(self._known, x)
        if found is not None:
            at, doubt = found
            radius, self._led = min(max(self._missed, doubt), RADIUS_KNOWN), at
        places = [at]
        if found is None and len(self._known) > 1:
            before = self._known[-2]
            move = (
                (last.at - before.at) / (last.log_speed - before.log_speed) * (x - last.log_speed)
            )
            places += [last.at + move] if _STILL < np.abs(move[:2]).max() < _FAR_LED else []
        told = [Candidate(0.0, GaitShape(*of[:2].tolist()), math.exp(of[2])) for of in places]
        return told, radius


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
        self.tracks = [_Track() for _ in self.searches]
        self.watts = [math.inf] * len(self.searches)

    def from_speed(self, speed: float, other: float) -> LeastPower:
        """Return the cheapest gait for a speed, begun at what was found for another one."""
        tracks = self.tracks
        self.tracks = [track.only(other) for track in tracks]
        try:
            return self.minimize(speed)
        finally:
            self.tracks = tracks

    def minimize(self, speed: float) -> LeastPower:
        """Return the cheapest gait for a speed; raises NotConverged."""
        found: list[LeastPower] = []
        lost: NotConverged | None = None
        for k, search in enumerate(self.searches):
            self.watts[k] = math.inf
            try:
                one = search.minimize(speed, *self.tracks[k].expected(speed))
            except NotConverged as error:
                lost = lost or error
                continue
            self.watts[k] = one.power_w
            self.tracks[k].add(search.optimum)
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
            robot,
            on,
            [speed_m_s],
            cost,
            limits,
            rtol,
            formulation,
            joint_stiffness_n_m,
            joint_damping_n_s_m,
        )

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
            robot,
            on,
            speeds,
            cost,
            limits,
            rtol,
            formulation,
            joint_stiffness_n_m,
            joint_damping_n_s_m,
        )

    waves = EitherWave(ground, search)
    found: dict[float, LeastPower | None] = {}
    for speed in sorted(set(speeds)):
        found[speed] = _reached(waves, speed)
    for speed, faster in _above_the_curve(found):
        if all(track.joins(speed, faster) for track in waves.tracks):
            continue
        anew, before = _reached(waves, speed, faster), found[speed]
        found[speed] = min((anew, before), key=lambda best: best.power_w if best else math.inf)
    named = {v: best and replace(best, formulation=formulation) for v, best in found.items()}
    return tuple(named[speed] for speed in speeds)


def _reached(waves: EitherWave, speed: float, other: float | None = None) -> LeastPower | None:
    """Return the cheapest gait, or None; other: a speed whose gait to go on from."""
    try:
        return waves.minimize(speed) if other is None else waves.from_speed(speed, other)
    except NotConverged:
        return None


def _above_the_curve(found: dict[float, LeastPower | None]) -> list[tuple[float, float]]:
    """Return speeds whose power lies above the line between their neighbours, and the faster one.

    In logarithms power mostly bends upwards over the speed. Where it does not, the faster gait may
    lie in another valley, which was the lowest already.
    """
    known = [(math.log(v), math.log(best.power_w), v) for v, best in found.items() if best]
    return [
        (v, faster)
        for (x0, y0, _), (x, y, v), (x1, y1, faster) in zip(
            known, known[1:], known[2:], strict=False
        )
        if y > y0 + (y1 - y0) * (x - x0) / (x1 - x0) + _ABOVE
    ][::-1]


def _wanted(speeds_m_s: Any) -> list[float]:
    """Return the wanted speeds as numbers; a front needs one at least."""
    speeds = np.asarray(speeds_m_s, dtype=object)
    if speeds.ndim != 1 or speeds.size == 0:
        raise BadInput(f"speeds_m_s is {speeds_m_s!r}; it must be a list of at least one speed")
    return [check_number("speed_m_s", speed, 0.0, open_low=True) for speed in speeds.tolist()]
