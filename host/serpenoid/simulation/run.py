"""A run: everything that was recorded, how far it is from another, and what its error warns of."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..base.files import write_csv
from ..base.rows import Plottable, Result, Row, detail, two_digits
from ..base.vectors import Array
from ..model.link_state import LinkState
from .scene import Scene, objection

ENERGY_COLUMNS = (
    "kinetic_j",
    "springs_j",
    "height_j",
    "joint_work_j",
    "friction_heat_j",
    "damper_heat_j",
    "positive_work_j",
)


@dataclass(frozen=True, slots=True)
class Difference:
    """Hold the largest differences between two runs over their common recorded times.

    position_m: of any link's centre. angle_rad: of any link. mean_speed: of the centre of mass from
    start to end, relative to the other run: nan where that one goes less than 1e-4 of its body's
    length a period. energy_j: of each column of the energy ledger (Run.energy_j), by its name; None
    where one of the two did not record it.
    """

    position_m: float
    angle_rad: float
    mean_speed: float
    energy_j: dict[str, float] | None = None

    def in_words(self) -> str:
        """Return places, angles and mean speed in one line."""
        speed = f", mean speed {self.mean_speed:+.2g}" if math.isfinite(self.mean_speed) else ""
        return f"{self.position_m:.2g} m, {self.angle_rad:.2g} rad{speed}"

    def size(self, body_m: float) -> float:
        """Return the larger of position in body lengths and angle in radians."""
        return max(self.position_m / body_m, self.angle_rad)


@dataclass(frozen=True, slots=True)
class RunError(Result):
    """Hold the estimated errors of a run.

    integration: of the method, four times the difference from a finer run. modelling: of the
    springs, from a run of the exact model; None for the explicit formulation, which has none. how:
    in words. settled: whether a yet finer run is nearer to the finer one than that is to the run;
    where it is not, the figures are no bound. believed_s: the time up to which the finer run agrees
    with this one to a hundredth of a body length and of a radian.
    """

    integration: Difference
    modelling: Difference | None
    how: str
    settled: bool = True
    believed_s: float = 0.0

    def rows(self) -> list[Row]:
        """Return the errors of time steps and springs."""
        parts = {"integration": self.integration, "modelling (springs)": self.modelling}
        return [
            detail(f"error by {name}", "", words=part.in_words())
            for name, part in parts.items()
            if part is not None
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return it for a JSON answer."""
        return asdict(self)

    def worst(self, body_m: float) -> float:
        """Return the largest error, positions in body lengths and angles in radians."""
        return sum(part.size(body_m) for part in (self.integration, self.modelling) if part)


@dataclass(frozen=True, repr=False)
class Run(Plottable):
    """Hold a run: T recorded times and arrays over n links, counted from the tail.

    Attributes
    ----------
    scene
        What was run.
    t_s : (T,)
        Times, s.
    x_m, y_m, theta_rad : (T, n)
        Link centres, m, and angles, rad, in the ground's frame.
    vx_m_s, vy_m_s, omega_rad_s : (T, n)
        Their rates, m/s and rad/s.
    joint_force_x_n, joint_force_y_n, joint_torque_nm : (T, n-1)
        On link i from link i+1, N and N m; empty unless "joints" is recorded.
    friction_x_n, friction_y_n : (T, n)
        Of the ground on each link, N; empty unless "friction" is recorded.
    energy_j : (T, 7)
        J, columns ENERGY_COLUMNS; empty unless "energy" is recorded. Three stores, then what
        joints, friction and dampers did since t = 0, and the work of joints that do not regenerate.
        This last one has a kink wherever a joint's power changes its sign. Adaptive methods find
        the kinks; fixed steps run over them. error_estimate tells how far any column is off.
    picked
        What an accuracy that was asked for chose, and why; else empty.
    steps
        How many the method took.
    local_error
        Sum of the errors that an adaptive method estimates for its steps, in the scale of
        scene.tolerance, relative (0: it has no estimate).

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> run = sn.simulate(sn.Scene(robot, ground, gait, duration_s=0.5, record=("energy",)))
    >>> bool(run.error_estimate.integration.position_m < 1e-6)
    True
    """

    scene: Scene
    t_s: Array
    x_m: Array
    y_m: Array
    theta_rad: Array
    vx_m_s: Array
    vy_m_s: Array
    omega_rad_s: Array
    joint_force_x_n: Array
    joint_force_y_n: Array
    joint_torque_nm: Array
    friction_x_n: Array
    friction_y_n: Array
    energy_j: Array
    steps: int
    local_error: float
    picked: str = ""
    _estimator: Callable[[Run], RunError] = field(kw_only=True, repr=False, compare=False)

    def state(self, index: int = -1) -> LinkState:
        """Return the state of all links at one recorded time."""
        return LinkState.row(self, index)

    @cached_property
    def error_estimate(self) -> RunError:
        """Return the estimated error of this run; the first use costs one to three more runs."""
        return self._estimator(self)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Return what somebody who uses this run must know; costs what error_estimate costs."""
        scene, error = self.scene, self.error_estimate
        steps, size = error.integration, error.integration.size(scene.robot.body_length_m)
        percent = 100 * abs(steps.mean_speed)
        springs_percent = 100 * error.modelling.mean_speed if error.modelling else 0.0
        stiffness_n_m, exact = scene.joint_stiffness_n_m, "formulation 'explicit'"
        finer = "take a smaller " + ("tolerance" if scene.adaptive else "dt_s")
        model = f" with {exact}" if objection("nonsmooth", scene) else ""
        warnings = {
            "the error estimate is no bound: finer runs disagree as much among themselves as with "
            f"this one; believe it up to t = {error.believed_s:.3g} s, or {finer}": (
                not error.settled
            ),
            f"the springs (k = {stiffness_n_m:g} N/m) change the mean speed by "
            f"{springs_percent:+.2g} %; the error falls as 1/k: take k = "
            f"{stiffness_n_m * abs(springs_percent):.1g} N/m for 1 %, or {exact}": (
                abs(springs_percent) > 1
            ),
            f"the time steps may change the mean speed by {percent:.2g} %; {finer}": (
                1 < percent < math.inf
            ),
            f"the time steps may put links off by {steps.position_m:.2g} m and "
            f"{steps.angle_rad:.2g} rad; {finer}": 1 < 10 * size < math.inf and not percent > 1,
            f"method {scene.method!r} knows nothing of sticking: at rest its wheels chatter, and "
            f"joint torques may be wrong by a third at any step; take method 'nonsmooth'{model}": (
                chatters(scene)
            ),
        }
        return tuple(text for text, holds in warnings.items() if holds)

    @property
    def centre_m(self) -> Array:
        """Return where the centre of mass was, x and y in m, (T, 2)."""
        return np.stack([self.x_m.mean(axis=1), self.y_m.mean(axis=1)], axis=1)

    @property
    def centre_velocity_m_s(self) -> Array:
        """Return how the centre of mass moved, x and y in m/s, (T, 2)."""
        return np.stack([self.vx_m_s.mean(axis=1), self.vy_m_s.mean(axis=1)], axis=1)

    @property
    def travel_m(self) -> float:
        """Return how far the centre of mass is from where it started, m."""
        return float(np.hypot(*(self.centre_m[-1] - self.centre_m[0])))

    def mean_speed_m_s(self, period_s: float) -> Array:
        """Return |displacement of the centre of mass| / period_s over the period (s) before, m/s.

        At the recorded times from one period after the start on, (times,); a time between two
        recorded ones is interpolated. Empty for a run shorter than a period.
        """
        times = self.t_s[self.t_s >= self.t_s[0] + period_s * (1 - 1e-9)]
        centre = self.centre_m @ [1, 1j]
        ends, starts = (np.interp(t, self.t_s, centre) for t in (times, times - period_s))
        return np.abs(ends - starts) / period_s

    @property
    def last_speed_m_s(self) -> float:
        """Return the mean speed over the last period, m/s; NaN where the records do not say."""
        period, t = self.scene.gait.period_s, self.t_s
        miss = np.abs(
            t - (t[-1] - period)
        ).min()  # distance from the time one period before the end
        rare = t.size > 1 and miss > 1e-6 * period and np.diff(t).max() > period / 8
        speeds = [] if rare else self.mean_speed_m_s(period)
        return float(speeds[-1]) if len(speeds) else np.nan

    def in_words(self) -> str:
        """Return how far the robot moves, and how fast."""
        speed = self.last_speed_m_s
        pace = "" if np.isnan(speed) else f", at {two_digits(speed)} m/s in the last period"
        return f"In {self.t_s[-1]:g} s the robot moves {two_digits(self.travel_m)} m{pace}."

    def rows(self) -> list[Row]:
        """Return displacement, speed, and extremes of what was recorded."""
        scene = self.scene
        step = f"tolerance {scene.tolerance:g}" if scene.adaptive else f"{scene.dt_s:g} s"
        how = f"{scene.formulation} model, {scene.method}, {step}"
        rows = [
            Row("method", "", words=f"{how}; {self.picked}" if self.picked else how),
            Row("displacement of the centre of mass", "m", self.travel_m),
            Row("speed over the last period", "m/s", self.last_speed_m_s),
        ]
        if self.joint_torque_nm.size:
            largest = float(np.abs(self.joint_torque_nm).max())
            rows.append(Row("largest torque of a joint", "N m", largest))
        ends = self.energy_j[-1].tolist() if self.energy_j.size else []
        for name, value in zip(ENERGY_COLUMNS, ends, strict=False):
            words = name.removesuffix("_j").replace("_", " ")
            rows.append(Row(f"{words} at the end", "J", value))
        return rows

    def to_csv(self, path: Path | str) -> None:
        """Write a CSV file: t_s; x of each link, then y, theta and their rates; what was recorded.

        A row for each recorded time. Links and joints count from 1 at the tail: vx2_m_s is vx_m_s
        of link 2; joint_force_x3_n is that on link 3 from link 4.
        """
        header, columns = ["t_s"], [self.t_s[:, None]]
        for name in self.__match_args__[2:13]:  # arrays over links or joints
            values = getattr(self, name)
            if values.size:
                columns.append(values)
                header += [_numbered(name, i + 1) for i in range(values.shape[1])]
        if self.energy_j.size:
            columns.append(self.energy_j)
            header += ENERGY_COLUMNS
        write_csv(Path(path), header, np.hstack(columns).tolist())

    @property
    def joint_power_w(self) -> Array:
        """Return -T_i phi_i', the mechanical power of each joint, W, (T, n-1)."""
        return -self.joint_torque_nm * np.diff(self.omega_rad_s, axis=1)


def _numbered(name: str, number: int) -> str:
    """Put the number of a link or joint before the unit: vx_m_s of link 2 is vx2_m_s."""
    return re.sub("_(m_s|rad_s|nm|rad|m|n)$", rf"{number}_\1", name)


def difference(
    run: Run, truth: Run, factor: float = 1.0, agreed_size: float = 0.01
) -> tuple[Difference, float]:
    """Return how far a run is from another, times a factor, and up to when both agree, s.

    At the times that both recorded; they agree where positions in body lengths and angles in rad
    differ by no more than agreed_size.
    """
    t_s, a, b = np.intersect1d(run.t_s, truth.t_s, return_indices=True)
    gap = run.x_m[a] - truth.x_m[b], run.y_m[a] - truth.y_m[b]
    position = np.hypot(*gap).max(axis=1)
    angle = np.abs(run.theta_rad[a] - truth.theta_rad[b]).max(axis=1)
    energy: dict[str, float] | None = None
    if run.energy_j.size and truth.energy_j.size:
        largest = factor * np.abs(run.energy_j[a] - truth.energy_j[b]).max(axis=0)
        energy = dict(zip(ENERGY_COLUMNS, largest.tolist(), strict=True))
    body_m, periods = run.scene.robot.body_length_m, t_s[-1] / run.scene.gait.period_s
    moves = truth.travel_m > 1e-4 * periods * body_m
    speed = run.travel_m / truth.travel_m - 1 if moves else math.nan
    largest_m, largest_rad = factor * float(position.max()), factor * float(angle.max())
    beyond = np.flatnonzero(np.maximum(position / body_m, angle) > agreed_size)
    believed_s = t_s[max(beyond[0] - 1, 0)] if beyond.size else t_s[-1]
    return Difference(largest_m, largest_rad, factor * speed, energy), float(believed_s)


def chatters(scene: Scene) -> bool:
    """Return whether dry friction meets a method that does not know sticking."""
    return scene.law == "dry" and scene.method != "nonsmooth"
