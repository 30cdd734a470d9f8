"""What moves the joints when the gait's angles are not simply imposed: torques, or servos."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .checks import check_number
from .errors import BadInput
from .vectors import number_array


@dataclass(frozen=True, slots=True)
class TorqueTable:
    """Hold joint torques by time: t_s (K,) rising, s, torque_nm (K, n-1), N m, linear in between.

    Before the first time and after the last the first and last rows hold. Raises BadInput.
    """

    t_s: NDArray[np.float64]
    torque_nm: NDArray[np.float64]

    def __post_init__(self) -> None:
        t, T = number_array("t_s", self.t_s), number_array("torque_nm", self.torque_nm)
        if t.ndim != 1 or T.ndim != 2 or t.size == 0 or T.shape[0] != t.size:
            raise BadInput(
                f"a torque table needs t_s (K,) and torque_nm (K, n-1); got {t.shape}, {T.shape}"
            )
        if not (np.isfinite(t).all() and np.isfinite(T).all() and (np.diff(t) > 0).all()):
            raise BadInput("a torque table needs finite torques at finite, rising times")
        object.__setattr__(self, "t_s", t)
        object.__setattr__(self, "torque_nm", T)


@dataclass(frozen=True, slots=True)
class Servo:
    """Describe the servo of a joint: towards its setpoint in proportion, damped, within limits.

    Torque stiffness_nm_rad (N m/rad) * error - damping_nms_rad (N m s/rad) * rate, where the error
    is what exceeds dead_band_rad, rad. At most torque_limit_nm (N m) when stalled, falling in a
    straight line to nothing at speed_limit_rad_s (rad/s), as a motor's does, and beyond it along
    the same line: a joint that is driven faster is braked. Braking has the whole torque. The
    setpoint is what the firmware's fixed-point code gives for the gait, held for each 20 ms frame.
    Raises BadInput.

    The defaults are round numbers for a hobby servo of 6 V (0.3 N m, 60 degrees in 0.12 s), not
    measurements.
    """

    stiffness_nm_rad: float = 3.0
    damping_nms_rad: float = 0.03
    torque_limit_nm: float = 0.3
    speed_limit_rad_s: float = 8.7
    dead_band_rad: float = 0.01

    def __post_init__(self) -> None:
        for name in self.__slots__:
            open_low = name in ("torque_limit_nm", "speed_limit_rad_s")
            value = check_number(name, getattr(self, name), 0.0, open_low=open_low)
            object.__setattr__(self, name, value)
