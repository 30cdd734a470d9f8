"""What moves the joints when the gait's angles are not simply imposed: torques, or servos."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
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
    """Describe the servos of all joints: position loop, motor, gear, supply.

    The loop asks for a duty d in [-1, 1] of the supply: d = (K e - D r) / S + r / w0, clamped, with
    the stiffness K = stiffness_nm_rad, the damping D = damping_nms_rad, the stalled torque
    S = torque_limit_nm, the free speed w0 = speed_limit_rad_s and the joint's rate r. The error e
    to the setpoint counts from dead_band_rad on. update_hz: how often the loop looks, on the clock
    of the frames; it holds its duty in between (0: it never holds).

    The motor gives S (V d - r / w0), a straight line from the stalled torque to none at the free
    speed; driven against its duty it brakes with more than S. V is the supply over its voltage
    without load, 1 - supply_sag * sum of d_i (V d_i - r_i / w0) over the joints: supply_sag is the
    share that one stalled servo takes. Inside all limits the torque is K e - D r.

    The gear adds the rotor's inertia armature_kg_m2 (times the gear ratio squared, as MuJoCo's
    armature), dry friction gear_friction_nm and viscous friction gear_damping_nms_rad.

    Setpoints are those of the firmware's fixed-point code, one each frame_s, s. Units: N m, rad, s,
    kg m^2. Raises BadInput.

    The defaults are round numbers for a servo of 6 V (0.3 N m, 60 degrees in 0.12 s) without rotor
    and gear, which no real one lacks: `sn.servo()` has those of real ones.
    """

    stiffness_nm_rad: float = 3.0
    damping_nms_rad: float = 0.03
    torque_limit_nm: float = 0.3
    speed_limit_rad_s: float = 8.7
    dead_band_rad: float = 0.01
    armature_kg_m2: float = 0.0
    gear_friction_nm: float = 0.0
    gear_damping_nms_rad: float = 0.0
    update_hz: float = 0.0
    supply_sag: float = 0.0
    frame_s: float = 0.02

    def __post_init__(self) -> None:
        for name in self.__slots__:
            open_low = name in ("torque_limit_nm", "speed_limit_rad_s", "frame_s")
            most = {"supply_sag": 1.0, "frame_s": 0.1, "update_hz": 1e4}.get(name, math.inf)
            value = check_number(name, getattr(self, name), 0.0, most, open_low=open_low)
            object.__setattr__(self, name, value)

    @property
    def simple(self) -> bool:
        """Tell whether it is a spring and a damper within limits, each joint by itself."""
        held = self.update_hz or self.supply_sag
        return not (held or self.armature_kg_m2 or self.gear_friction_nm)


def core_servo(servo: Servo) -> Any:
    """Return a servo as the core takes it."""
    core = _core.Servo()
    for name in _core.SERVO_FIELDS:
        setattr(core, name, getattr(servo, name))
    return core
