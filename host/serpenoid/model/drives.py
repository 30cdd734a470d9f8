"""What moves the joints when the gait's angles are not simply imposed: torques, servos, kinds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .checks import check_choice, check_number
from .errors import BadInput
from .vectors import number_array

# What follows the stalled torque S (stiffness, friction) or the motor's line S / w0 (damping,
# rotor): their own sigma says how uncertain the ratio is.
_WITH_TORQUE = ("stiffness_nm_rad", "gear_friction_nm")
_WITH_LINE = ("damping_nms_rad", "gear_damping_nms_rad", "armature_kg_m2")
_HUNTS, _TRIES = 0.97, 1000
UNCERTAIN = (
    "torque_limit_nm",
    "speed_limit_rad_s",
    *_WITH_TORQUE,
    *_WITH_LINE,
    "dead_band_rad",
    "supply_sag",
)


@dataclass(frozen=True, slots=True)
class TorqueTable:
    """Hold joint torques by time: linear in between, constant before the first and after the last.

    Attributes
    ----------
    t_s : (K,)
        Times, rising, s.
    torque_nm : (K, n-1)
        Torques, N m.

    Raises
    ------
    BadInput
        For times that do not rise, or arrays that do not fit.
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

    The defaults are round numbers for a servo of 6 V (0.3 N m, 60 degrees in 0.12 s) without rotor
    and gear, which no real one lacks: `sn.servo()` has those of real ones.

    Attributes
    ----------
    stiffness_nm_rad, damping_nms_rad
        K and D of the position loop, N m/rad and N m s/rad.
    torque_limit_nm
        Stalled torque S, N m.
    speed_limit_rad_s
        Free speed w0, rad/s.
    dead_band_rad
        The loop's error counts from here on, rad.
    armature_kg_m2
        The rotor's inertia times the gear ratio squared, kg m^2.
    gear_friction_nm, gear_damping_nms_rad
        Dry and viscous friction of the gear, N m and N m s/rad.
    update_hz
        How often the loop looks, Hz, on the clock of the frames; 0: at all times.
    supply_sag
        Share of the supply's voltage that one stalled servo takes.
    frame_s
        Time from one setpoint to the next, s; setpoints are the firmware's, in fixed point.
    backlash_rad
        Play of the gear, rad: so far the output turns while the rotor is held.

    Raises
    ------
    BadInput
        For values out of range.

    Notes
    -----
    The loop asks for a duty d in [-1, 1] of the supply: d = (K e - D r) / S + r / w0, clamped, with
    the joint's rate r and the error e to the setpoint. It sees the output, and holds its duty
    between two looks. The motor gives S (V d - r / w0), a straight line from the stalled torque to
    none at the free speed; driven against its duty it brakes with more than S. V is the supply over
    its voltage without load, 1 - supply_sag * sum of d_i (V d_i - r_i / w0) over the joints. Inside
    all limits the torque is K e - D r.
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
    backlash_rad: float = 0.0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            open_low = name in ("torque_limit_nm", "speed_limit_rad_s", "frame_s")
            most = {"supply_sag": 1.0, "frame_s": 0.1, "update_hz": 1e4, "backlash_rad": 0.5}.get(
                name, math.inf
            )
            value = check_number(name, getattr(self, name), 0.0, most, open_low=open_low)
            object.__setattr__(self, name, value)
        if self.backlash_rad > 0 and self.armature_kg_m2 == 0:
            raise BadInput(
                f"backlash_rad is {self.backlash_rad:g} and armature_kg_m2 is 0; a gear with play "
                "needs a rotor behind it: give armature_kg_m2 above 0"
            )

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


@dataclass(frozen=True, slots=True)
class ServoKind:
    """Describe servos of one kind: the typical one, and the doubt about any other.

    Attributes
    ----------
    name
        Name of the kind.
    servo
        The typical servo.
    sigma
        Standard deviation of the logarithm of Servo's fields, by name (0.1 is 10 %); fields without
        one are exact. Stiffness and gear friction are drawn as ratios to the stalled torque;
        damping, gear damping and rotor as ratios to torque over speed.
    updates_hz
        Rates at which loops of this kind may look, Hz, each as likely; () for the typical one's.
    source
        Where the values come from.
    drawn
        Servos that a measurement leaves possible, each as likely; if any, no others are drawn.

    Raises
    ------
    BadInput
        For values out of range and names that Servo does not have.
    """

    name: str
    servo: Servo
    sigma: Mapping[str, float] = field(default_factory=dict)
    updates_hz: tuple[float, ...] = ()
    source: str = ""
    drawn: tuple[Servo, ...] = ()

    def __post_init__(self) -> None:
        for name, value in self.sigma.items():
            check_choice("sigma", name, UNCERTAIN)
            check_number(f"sigma of {name}", value, 0.0, 3.0)
        for rate in self.updates_hz:
            check_number("updates_hz", rate, 0.0, 1e4)
        object.__setattr__(self, "sigma", MappingProxyType(dict(self.sigma)))

    @property
    def exact(self) -> bool:
        """Tell whether nothing is in doubt."""
        doubt = any(self.sigma.values()) or len(self.updates_hz) > 1
        return not doubt and len(self.drawn) < 2

    def draws(self, count: int, seed: int = 0) -> list[Servo]:
        """Return servos of this kind, drawn at random.

        Parameters
        ----------
        count, seed
            Number of servos and the seed of the draw.

        Returns
        -------
        list of Servo
            `count` servos.

        Raises
        ------
        BadInput
            For a count that is no whole number of 1 or more.
        """
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise BadInput(f"count is {count!r}; it must be a whole number, 1 or more")
        rng = np.random.default_rng(seed)
        if self.drawn:
            times = -(-count // len(self.drawn))
            order = [int(k) for _ in range(times) for k in rng.permutation(len(self.drawn))]
            return [self.drawn[k] for k in order[:count]]
        return [self._sound(rng) for _ in range(count)]

    def _sound(self, rng: np.random.Generator) -> Servo:
        """Return a servo that does not hunt by itself: such ones are not sold."""
        drawn = self._draw(rng)
        for _ in range(_TRIES):
            if not hunts(drawn):
                break
            drawn = self._draw(rng)
        return drawn

    def _draw(self, rng: np.random.Generator) -> Servo:
        units = [float(rng.normal()) for _ in UNCERTAIN]
        made = self.at(units)
        if not self.updates_hz:
            return made
        return replace(made, update_hz=float(rng.choice(self.updates_hz)))

    def at(self, units: Sequence[float]) -> Servo:
        """Return the servo whose UNCERTAIN fields lie off the typical ones by units, in sigma."""
        factor = {
            name: math.exp(self.sigma.get(name, 0.0) * x)
            for name, x in zip(UNCERTAIN, units, strict=True)
        }
        torque, line = factor["torque_limit_nm"], 1 / factor["speed_limit_rad_s"]
        for name in _WITH_TORQUE:
            factor[name] *= torque
        for name in _WITH_LINE:
            factor[name] *= torque * line
        values = {name: getattr(self.servo, name) * factor[name] for name in UNCERTAIN}
        values["supply_sag"] = min(values["supply_sag"], 1.0)
        return replace(self.servo, **values)

    def units_of(self, servo: Servo) -> list[float]:
        """Return by how many sigma a servo's UNCERTAIN fields lie off: the inverse of `at`."""
        log = {
            name: math.log(getattr(servo, name) / getattr(self.servo, name))
            if self.sigma.get(name) and getattr(self.servo, name)
            else 0.0
            for name in UNCERTAIN
        }
        torque, line = log["torque_limit_nm"], -log["speed_limit_rad_s"]
        for names, common in ((_WITH_TORQUE, torque), (_WITH_LINE, torque + line)):
            for name in names:
                log[name] -= common
        return [log[n] / self.sigma[n] if self.sigma.get(n) else 0.0 for n in UNCERTAIN]


def hunts(servo: Servo) -> bool:
    """Tell whether a servo hunts by itself; such ones are not sold."""
    return loop_radius(servo) >= _HUNTS


def loop_radius(servo: Servo) -> float:
    """Return by what factor an unloaded servo's swing changes in 20 ms; above 1 it hunts.

    The rotor alone, without dry friction, dead band and limits: J r' = S d - (S / w0 + c) r with
    the duty held between two looks. 0 where nothing is held or there is no rotor.
    """
    J, S = servo.armature_kg_m2, servo.torque_limit_nm
    if servo.update_hz == 0 or J == 0:
        return 0.0
    line = S / servo.speed_limit_rad_s
    rate = (line + servo.gear_damping_nms_rad) / J
    look = 1 / servo.update_hz
    decay = math.exp(-rate * look)
    glide = (1 - decay) / rate  # angle by a unit of rate, rate by a unit of acceleration
    drift = (look - glide) / rate  # angle by a unit of acceleration
    gain = np.array([servo.stiffness_nm_rad, servo.damping_nms_rad - line]) / J
    step = np.array([[1.0, glide], [0.0, decay]]) - np.outer([drift, glide], gain)
    return float(np.abs(np.linalg.eigvals(step)).max() ** (0.02 / look))
