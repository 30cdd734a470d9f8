"""Stability bounds hold for every shape of the cycle, against mass matrices by differences."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
import serpenoid as sn
from numpy.typing import NDArray
from serpenoid.simulation.stability import modes

Array = NDArray[np.float64]
GROUND = sn.Ground(0.1, 10.0)
# A small inertia, so that bending counts; neither gait is straightest at phase 0.
ROBOT = sn.Robot(6, 1.0, 0.12, 1e-4)
SPRINGS = sn.Scene(
    ROBOT,
    GROUND,
    sn.Gait(1.2, math.pi, 5.0, joint_shift_rad=(math.pi / 2,) * 5),
    formulation="implicit",
    joint_stiffness_n_m=1.0,
    dt_s=1e-6,
)
SERVOS = sn.Scene(
    ROBOT,
    GROUND,
    sn.Gait(0.6, 2.75, 5.0),
    drive="servo",
    dt_s=1e-6,
    servo=sn.Servo(stiffness_nm_rad=1.0, damping_nms_rad=0.01),
)


def link_angles(gait: sn.Gait, phase: float) -> Array:
    shift = gait.joint_shift_rad or (0.0,) * 5
    bends = [gait.alpha_rad * math.sin(phase + i * gait.beta_rad + s) for i, s in enumerate(shift)]
    return np.concatenate([[0.0], np.cumsum(bends)])


def halves(theta: Array) -> Array:
    return ROBOT.link_length_m / 2 * np.stack([np.cos(theta), np.sin(theta)], axis=1)


def centres(q: Array) -> Array:
    """Return the centres of a connected chain, (2 n,), from its tail's place and its angles."""
    half = halves(q[2:])
    return np.cumsum(np.concatenate([q[None, :2], half[:-1] + half[1:]]), axis=0).ravel()


def jacobian(f: Callable[[Array], Array], q: Array) -> Array:
    step = 1e-6 * np.eye(q.size)
    return np.stack([(f(q + d) - f(q - d)) / 2e-6 for d in step], axis=1)


def stiffest_spring(theta: Array) -> float:
    """Return the largest mode of the gaps by loose links that turn together, 1/kg."""

    def gaps(q: Array) -> Array:
        half, places = halves(theta + q[-1]), q[:-1].reshape(-1, 2)
        return ((places - half)[1:] - (places + half)[:-1]).ravel()

    places = centres(np.concatenate([np.zeros(2), theta]))
    J = jacobian(gaps, np.append(places, 0.0))
    inverse = np.array([1 / ROBOT.link_mass_kg] * 12 + [1 / (6 * ROBOT.inertia_kg_m2)])
    return float(np.linalg.eigvalsh(J * inverse @ J.T).max())


def stiffest_servo(theta: Array) -> float:
    """Return the largest mode of the joints' mobility of a free chain, 1/(kg m^2)."""
    J = jacobian(centres, np.concatenate([np.zeros(2), theta]))
    mass = ROBOT.link_mass_kg * J.T @ J + np.diag([0.0] * 2 + [ROBOT.inertia_kg_m2] * 6)
    bend = np.diff(np.eye(8)[2:], axis=0)
    return float(np.linalg.eigvalsh(bend @ np.linalg.inv(mass) @ bend.T).max())


@pytest.mark.parametrize(
    ("scene", "stiffest"), [(SPRINGS, stiffest_spring), (SERVOS, stiffest_servo)]
)
def test_the_stiffest_shape_of_the_cycle_counts(
    scene: sn.Scene, stiffest: Callable[[Array], float]
) -> None:
    every = [stiffest(link_angles(scene.gait, p)) for p in np.linspace(0, math.pi, 65)]
    assert modes(scene)[0].max() == pytest.approx(max(every), rel=5e-3)
    assert max(every) > 1.4 * every[0]  # phase 0 alone would not do
