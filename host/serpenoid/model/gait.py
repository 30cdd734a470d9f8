"""The gait of Eq. 57: one sine wave that runs along the joints."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .checks import check_number


@dataclass(frozen=True, slots=True)
class Gait:
    """Describe the joint angles phi_i(t) = offset + alpha sin(omega t + (i - 1) beta), Eq. 57.

    phi_i = theta_{i+1} - theta_i is the angle of joint i, i = 1..n-1 counted from the tail.
    alpha_rad: amplitude, 0..pi. beta_rad: phase lag from joint to joint. omega_rad_s: angular
    rate, above 0. offset_rad: constant bend of every joint, which steers. Raises BadInput.
    """

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    offset_rad: float = 0.0

    def __post_init__(self) -> None:
        checked = {
            "alpha_rad": check_number("alpha_rad", self.alpha_rad, 0.0, math.pi),
            "beta_rad": check_number("beta_rad", self.beta_rad, -2 * math.pi, 2 * math.pi),
            "omega_rad_s": check_number("omega_rad_s", self.omega_rad_s, 0.0, open_low=True),
            "offset_rad": check_number("offset_rad", self.offset_rad, -math.pi, math.pi),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def period_s(self) -> float:
        """Return 2 pi / omega."""
        return 2 * math.pi / self.omega_rad_s
