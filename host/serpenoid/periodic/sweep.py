"""Periodic states over a grid of gaits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..model.core_model import check_parts, core_model
from ..model.errors import BadInput
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from .steady import MAX_ELEMENTS, check_ground


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
    check_parts(robot, ground)
    check_ground(ground, rtol)
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
