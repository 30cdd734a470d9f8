"""The periodic state of a gait, solved for directly: speed, powers, stability, one gait or many."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..model.checks import check_number
from ..model.core_model import core_model
from ..model.errors import BadInput, NotConverged
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot

MAX_ELEMENTS = 1024


@dataclass(frozen=True, slots=True)
class Steady:
    """Hold the periodic state of a gait (explicit model), after all memory of the start is gone.

    speed_m_s: |displacement over a period| / period, along the mean direction of travel (a gait
    that turns: over the period that begins at phase 0). power_w: net mean of P = -sum T_i phi_i';
    abs_power_w, positive_power_w: means of sum |P_i| and sum max(P_i, 0). turn_rad_per_cycle:
    change of heading a period. error_estimate: of the speed, relative (where the speed is next to
    nothing: to 1e-4 of body length times omega); power_error_w: of the powers. direction_rad:
    direction of travel counted from the heading of link 1 at phase 0. body_velocity: (Vx, Vy,
    theta_1') at phase 0, velocity of the centre of mass along and across link 1, m/s, m/s, rad/s.
    monodromy: derivative (3, 3) of (Vx, Vy, angular momentum) after a period by those before it.
    """

    robot: Robot
    ground: Ground
    gait: Gait
    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    turn_rad_per_cycle: float
    error_estimate: float
    power_error_w: float
    direction_rad: float
    body_velocity: NDArray[np.float64]
    monodromy: NDArray[np.float64]

    @property
    def floquet_multipliers(self) -> NDArray[np.complex128]:
        """Return the three factors by which a small disturbance changes each period, by size."""
        values = np.linalg.eigvals(self.monodromy).astype(complex)
        return values[np.argsort(-abs(values))]

    @property
    def stable(self) -> bool:
        """Tell whether small disturbances die out."""
        return bool(abs(self.floquet_multipliers[0]) < 1.0)

    @property
    def settling_time_s(self) -> float:
        """Return the time in which the slowest disturbance falls to 1/e; inf when none does."""
        slowest = float(abs(self.floquet_multipliers[0]))
        if slowest >= 1.0:
            return math.inf
        return self.gait.period_s / -math.log(slowest) if slowest > 0 else 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers, for JSON."""
        multipliers = self.floquet_multipliers
        return {
            "speed_m_s": self.speed_m_s,
            "power_w": self.power_w,
            "abs_power_w": self.abs_power_w,
            "positive_power_w": self.positive_power_w,
            "turn_rad_per_cycle": self.turn_rad_per_cycle,
            "error_estimate": self.error_estimate,
            "power_error_w": self.power_error_w,
            "settling_time_s": self.settling_time_s,
            "floquet_multipliers": [[m.real, m.imag] for m in multipliers.tolist()],
        }


@dataclass(frozen=True, slots=True)
class Sweep:
    """Hold speeds and powers over a grid of gaits; all arrays are indexed [alpha, beta, omega]."""

    alpha_rad: NDArray[np.float64]
    beta_rad: NDArray[np.float64]
    omega_rad_s: NDArray[np.float64]
    speed_m_s: NDArray[np.float64]
    power_w: NDArray[np.float64]
    abs_power_w: NDArray[np.float64]
    positive_power_w: NDArray[np.float64]
    converged: NDArray[np.bool_]


def _relative(error: float, speed: float, robot: Robot, gait: Gait) -> float:
    """Return error over speed, or over 1e-4 of body length x rate where there is no speed."""
    return error / max(speed, 1e-4 * gait.omega_rad_s * robot.links * robot.link_length_m)


def _refuse_frictionless(ground: Ground) -> None:
    if ground.ct == ground.cn == ground.ft0 == ground.fn0 == 0:
        raise BadInput(
            "there is no friction at all (ct, cn, ft0 and fn0 are 0): nothing damps the start, so "
            "there is no one periodic state; give some friction, or use simulate"
        )


def steady_gait(
    robot: Robot, ground: Ground, gait: Gait, *, rtol: float = 1e-6, powers: bool = True
) -> Steady:
    """Solve for the periodic state of a gait under imposed joint angles, explicit model.

    Newton's method on the period map, with half a period where mirror symmetry allows it; viscous
    ground by Gauss collocation, dry ground as the set-valued law with exact sticking. rtol: wanted
    relative accuracy of speed and powers, 0.1 to 1e-12 (dry ground: to 1e-7, powers to 10 rtol).
    powers=False leaves abs_power_w and positive_power_w out (0) and is faster. Raises BadInput, and
    NotConverged with the accuracy that was reached.
    """
    check_number("rtol", rtol, 1e-7 if ground.dry else 1e-12, 0.1)
    _refuse_frictionless(ground)
    s = _core.steady(core_model(robot, ground, gait), rtol, powers, MAX_ELEMENTS)
    error = _relative(s.speed_error, s.speed, robot, gait)
    if not s.converged:
        raise NotConverged(
            f"no periodic state found to rtol {rtol:g} for {gait} on {ground}: the speed changed "
            f"by {error:.1g} of itself at the last refinement; ask for a larger rtol, or follow "
            "the motion in time with simulate"
        )
    return Steady(
        robot, ground, gait, s.speed, s.power, s.abs_power, s.positive_power, s.turn, error,
        s.power_error, s.direction, s.start, s.monodromy,
    )  # fmt: skip


def _axis(name: str, values: ArrayLike) -> NDArray[np.float64]:
    axis = np.atleast_1d(np.asarray(values, dtype=float))
    if axis.ndim != 1 or axis.size == 0:
        raise BadInput(f"{name} has shape {axis.shape}; it must be a list of at least one number")
    return axis


def sweep(
    robot: Robot,
    ground: Ground,
    *,
    alpha_rad: ArrayLike,
    beta_rad: ArrayLike,
    omega_rad_s: ArrayLike,
    rtol: float = 1e-6,
    powers: bool = True,
    progress: Callable[[int], None] | None = None,
) -> Sweep:
    """Solve every gait of a grid; results are indexed [alpha, beta, omega].

    Each value has the accuracy that steady_gait gives, and `converged` is False where it was not
    reached (the value then is the best that was found). progress is called with the number of
    gaits done since its last call. Raises BadInput.
    """
    check_number("rtol", rtol, 1e-7 if ground.dry else 1e-12, 0.1)
    _refuse_frictionless(ground)
    a, b = _axis("alpha_rad", alpha_rad), _axis("beta_rad", beta_rad)
    w = _axis("omega_rad_s", omega_rad_s)
    for rate in w:
        Gait(0.0, 0.0, float(rate))
    out = np.empty((5, a.size, b.size, w.size))
    for i, alpha in enumerate(a.tolist()):
        for j, beta in enumerate(b.tolist()):
            model = core_model(robot, ground, Gait(alpha, beta, float(w[0])))
            out[:, i, j] = _core.steady_row(model, w, rtol, powers, MAX_ELEMENTS)
            if progress is not None:
                progress(w.size)
    return Sweep(a, b, w, out[0], out[1], out[2], out[3], out[4] > 0.5)
