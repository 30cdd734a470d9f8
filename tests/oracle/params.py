"""Parameters of a snake robot, its ground and its gait, as all modules of this folder take them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


@dataclass(frozen=True)
class Params:
    """Hold one robot on one ground: SI units, friction per link.

    `half_length_m` is the paper's l, half the link length. `inertia_kg_m2` left at None is the
    uniform rod's m l**2 / 3. `gravity_m_s2` is the component of gravity in the plane of motion.
    `ct_back`, `ft0_back`: along the links towards the tail, if not as towards the head.
    """

    links: int
    mass_kg: float = 1.0
    half_length_m: float = 0.06
    inertia_kg_m2: float | None = None
    ct: float = 0.1
    cn: float = 10.0
    ft0: float = 0.0
    fn0: float = 0.0
    gravity_m_s2: tuple[float, float] = (0.0, 0.0)
    ct_back: float | None = None
    ft0_back: float | None = None

    @property
    def backwards(self) -> tuple[float, float]:
        """Return C and F_0 along the links towards the tail."""
        return (
            self.ct if self.ct_back is None else self.ct_back,
            self.ft0 if self.ft0_back is None else self.ft0_back,
        )

    @property
    def inertia(self) -> float:
        """Return the moment of inertia of a link about its centre, kg m**2."""
        if self.inertia_kg_m2 is not None:
            return self.inertia_kg_m2
        return self.mass_kg * self.half_length_m**2 / 3.0


@dataclass(frozen=True)
class Gait:
    """Hold a gait: joint angle i is offset + alpha sin(omega t + (i - 1) beta) (Eq. 57)."""

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    offset_rad: float = 0.0

    def angles(self, t_s: float, joints: int) -> tuple[Array, Array, Array]:
        """Return the joint angles and their first and second rates, each (joints,)."""
        phase = self.omega_rad_s * t_s + np.arange(joints) * self.beta_rad
        phi = self.offset_rad + self.alpha_rad * np.sin(phase)
        phi_dot = self.alpha_rad * self.omega_rad_s * np.cos(phase)
        return phi, phi_dot, -self.alpha_rad * self.omega_rad_s**2 * np.sin(phase)
