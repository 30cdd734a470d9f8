"""Periodic states over grids of gaits, here or on a cluster."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.checks import check_kind
from ..base.errors import BadInput, NotConverged
from ..base.long_calls import Progress, in_threads, threads_to_use
from ..base.rows import Plottable, two_digits
from ..base.vectors import Array, number_array
from ..model.core_model import check_parts
from ..model.drives import Servo, ServoKind
from ..model.gait import Gait, gait_name
from ..model.ground import Ground
from ..model.robot import Robot
from .cluster import Shape, solve_on_cluster, solve_shapes
from .servo_steady import with_servo
from .steady import check_ground, speed_floor_m_s, steady_gait

MAX_GAITS = 10**8  # gaits of a grid; eleven numbers each take 9 GB


class BestGait(NamedTuple):
    """A gait of a grid with its speed, and the energy of a metre without regeneration."""

    gait: Gait
    speed_m_s: float
    energy_j_m: float


@dataclass(frozen=True, slots=True, repr=False)
class Sweep(Plottable):
    """Hold periodic states over a grid; all arrays but the axes are indexed [alpha, beta, omega].

    Attributes
    ----------
    alpha_rad
        Amplitudes, rad: an axis of the grid.
    beta_rad
        Phase lags, rad: an axis of the grid.
    omega_rad_s
        Rates, rad/s: an axis of the grid.
    speed_m_s
        Speed of each gait, m/s, as in Steady.
    turn_rad_per_cycle
        Change of heading in a period, rad.
    settling_time_s
        Time in which the slowest disturbance falls to 1/e, s.
    power_w
        Net mean of P = -sum T_i phi_i', W.
    abs_power_w
        Mean of sum |P_i|, W.
    positive_power_w
        Mean of sum max(P_i, 0), W.
    error_estimate
        Relative error of the speed.
    power_error_w
        Error of power_w, W.
    positive_power_error_w
        Error of positive_power_w, W. That of abs_power_w is power_error_w plus twice this one.
    converged
        Whether the wanted accuracy was reached; where not, the best value is given with its error.
    servo_speed_m_s
        Speed with the (typical) servo, m/s; NaN where the motion does not settle, None without a
        servo. All other values are of ideal joints.
    servo_low_m_s
        Lower end of the 95 % band of servos drawn from the kind, m/s; NaN also where the gait is
        too fast for the servo, or the robot too heavy.
    servo_high_m_s
        Upper end of that band, m/s.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> grid = sn.sweep(robot, ground, alpha_rad=[0.4, 0.5], beta_rad=[1.4], omega_rad_s=[5.0])
    >>> grid.speed_m_s.shape, bool(grid.converged.all())
    ((2, 1, 1), True)
    """

    alpha_rad: NDArray[np.float64]
    beta_rad: NDArray[np.float64]
    omega_rad_s: NDArray[np.float64]
    speed_m_s: NDArray[np.float64]
    power_w: NDArray[np.float64]
    abs_power_w: NDArray[np.float64]
    positive_power_w: NDArray[np.float64]
    turn_rad_per_cycle: NDArray[np.float64]
    error_estimate: NDArray[np.float64]
    power_error_w: NDArray[np.float64]
    positive_power_error_w: NDArray[np.float64]
    settling_time_s: NDArray[np.float64]
    converged: NDArray[np.bool_]
    servo_speed_m_s: NDArray[np.float64] | None = None
    servo_low_m_s: NDArray[np.float64] | None = None
    servo_high_m_s: NDArray[np.float64] | None = None

    def best(self, *, per_metre: bool = False) -> BestGait | None:
        """Return the fastest gait, or that with the least energy per metre; None if none travels.

        With a servo, the speed with the servo counts, and only gaits that it can follow. The
        power is that of ideal joints that do not regenerate.
        """
        speed_m_s = np.where(self.converged, self.speed_m_s, np.nan)
        if self.servo_speed_m_s is not None and self.servo_low_m_s is not None:
            speed_m_s = np.where(np.isnan(self.servo_low_m_s), np.nan, self.servo_speed_m_s)
        speed_m_s = np.where(speed_m_s > 0, speed_m_s, np.nan)
        energy_j_m = self.positive_power_w / speed_m_s
        score = -energy_j_m if per_metre else speed_m_s
        if np.isnan(score).all():
            return None
        index = np.unravel_index(np.nanargmax(score), score.shape)
        shape = zip((self.alpha_rad, self.beta_rad, self.omega_rad_s), index, strict=True)
        alpha_rad, beta_rad, omega_rad_s = (float(values[k]) for values, k in shape)
        gait = Gait(alpha_rad, beta_rad, omega_rad_s)
        return BestGait(gait, float(speed_m_s[index]), float(energy_j_m[index]))

    def in_words(self) -> str:
        """Return the fastest gait, the cheapest metre, and how many gaits do not settle."""
        sentences = [f"{self.speed_m_s.size} gaits."]
        for word, per_metre in (("Fastest", False), ("Cheapest metre", True)):
            best = self.best(per_metre=per_metre)
            if best is not None and not (per_metre and best.energy_j_m == 0):
                cost = f", {two_digits(best.energy_j_m)} J/m" if best.energy_j_m else ""
                speed = two_digits(best.speed_m_s)
                sentences.append(f"{word}: {gait_name(best.gait)}, {speed} m/s{cost}.")
        lost = int((~self.converged).sum())
        return " ".join([*sentences, f"{lost} do not settle." if lost else "All settle."])

    def to_dict(self) -> dict[str, Any]:
        """Return lists, indexed [alpha, beta, omega]; None stands for what is not finite."""
        plain: dict[str, Any] = {
            "alpha_deg": np.degrees(self.alpha_rad).round(10).tolist(),
            "beta_deg": np.degrees(self.beta_rad).round(10).tolist(),
        }
        for name in self.__match_args__:
            values = getattr(self, name)
            if values is not None:
                cells = values.astype(object)
                cells[~np.isfinite(values)] = None
                plain[name] = cells.tolist()
        return plain


def sweep(
    robot: Robot,
    ground: Ground,
    *,
    alpha_rad: ArrayLike,
    beta_rad: ArrayLike,
    omega_rad_s: ArrayLike,
    rtol: float = 1e-6,
    powers: bool = True,
    servo: Servo | ServoKind | None = None,
    threads: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Solve every gait of a grid.

    Parameters
    ----------
    robot
        What crawls.
    ground
        Friction of what it crawls on.
    alpha_rad
        Amplitudes, rad: a value or a list.
    beta_rad
        Phase lags, rad: a value or a list.
    omega_rad_s
        Rates, rad/s: a value or a list.
    rtol
        Accuracy of the speed, relative.
    powers
        Whether to compute powers, too, which takes longer.
    servo
        What moves the joints, in a second solution beside that of ideal joints. It takes some 15 ms
        a gait on this machine (no cluster), 15 times that for a kind whose values are uncertain.
    threads
        Number of threads; all processors unless given.
    scheduler
        Address of a Dask cluster, such as "tcp://10.0.0.1:8786", with serpenoid[dask] on all its
        workers. The results are the same to the last bit.
    progress
        Called with the number of gaits solved since the last call, first for ideal joints, then for
        servos; may raise to stop.

    Returns
    -------
    Sweep
        Arrays indexed [alpha, beta, omega].

    Raises
    ------
    BadInput
        For arguments out of range.
    ClusterFailed
        If the cluster cannot be reached or has other versions.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> grid = sn.sweep(robot, ground, alpha_rad=[0.4, 0.5], beta_rad=[1.4], omega_rad_s=[5.0])
    >>> grid.speed_m_s.shape, bool(grid.converged.all())
    ((2, 1, 1), True)
    """
    if servo is not None:
        check_kind("servo", servo, Servo, ServoKind)
    check_kind("powers", powers, bool)
    check_parts(robot, ground)
    check_ground(ground, rtol)
    names = "alpha_rad", "beta_rad", "omega_rad_s"
    ranges = alpha_rad, beta_rad, omega_rad_s
    axes: list[NDArray[Any]] = [
        grid_axis(name, values) for name, values in zip(names, ranges, strict=True)
    ]
    size = [axis.size for axis in axes]
    if math.prod(size) > MAX_GAITS:
        raise BadInput(f"the grid has {math.prod(size):.3g} gaits; the limit is {MAX_GAITS:.0e}")
    *angles, rates = (axis.tolist() for axis in axes)
    for rate in rates:
        Gait(0.0, 0.0, rate)  # raises BadInput if it is out of range
    shapes = [(robot, ground, Gait(alpha, beta, rates[0])) for alpha, beta in product(*angles)]
    count = threads_to_use(threads)
    if scheduler is None:
        table = solve_shapes(shapes, rates, rtol, powers, count, progress)
    else:
        table = solve_on_cluster(scheduler, shapes, rates, rtol, powers, progress)
    values = gait_figures(shapes, axes[2], table)
    if servo is not None:
        values += _with_servo(shapes, rates, servo, count, progress)
    return Sweep(*axes, *(np.reshape(column, size) for column in values))


def gait_figures(shapes: Sequence[Shape], rates: Array, table: Array) -> list[Any]:
    """Return the fields of Sweep from speed to converged, (shapes, rates) each, of a table."""
    *figures, log_multiplier, _, converged = np.moveaxis(table, -1, 0)
    floors = speed_floor_m_s(shapes[0][0], 1.0) * rates
    # The core gives the error of the speed in m/s.
    figures[5] = figures[5] / np.maximum(figures[0], floors)
    with np.errstate(divide="ignore"):
        settling_s = np.where(log_multiplier < 0, -math.tau / rates / log_multiplier, math.inf)
    return [*figures, settling_s, converged > 0]


def grid_axis(name: str, values: ArrayLike) -> Array:
    """Return an axis of the grid, at least one number."""
    numbers = np.atleast_1d(number_array(name, values))
    if numbers.ndim != 1 or numbers.size == 0:
        raise BadInput(
            f"{name} has shape {numbers.shape}; it must be a list of at least one number"
        )
    return numbers


def _with_servo(
    shapes: Sequence[Shape],
    rates: Sequence[float],
    servo: Servo | ServoKind,
    threads: int,
    progress: Progress | None,
) -> list[Any]:
    """Return Sweep's speed with the typical servo, and both ends of its band, m/s."""

    def solved(pair: tuple[Shape, float]) -> tuple[float, float, float]:
        (robot, ground, bend), rate = pair
        try:
            gait = replace(bend, omega_rad_s=rate)
            # A grid has many gaits: each is known to 0.1 %, its band from 64 drawn servos.
            ideal = steady_gait(robot, ground, gait, rtol=1e-3, powers=False)
            moved = with_servo(ideal, servo, draws=64, threads=1)
        except NotConverged:
            return np.nan, np.nan, np.nan
        return moved.speed_m_s, moved.low_m_s, moved.high_m_s

    return list(zip(*in_threads(solved, product(shapes, rates), progress, threads), strict=True))
