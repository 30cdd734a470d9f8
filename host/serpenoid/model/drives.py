"""What moves the joints when the gait's angles are not simply imposed: torques, servos, kinds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import NormalDist
from types import MappingProxyType
from typing import Any

import numpy as np

from .. import _core
from ..base.checks import (
    NOT_NEGATIVE,
    POSITIVE,
    Limits,
    check_choice,
    check_fields,
    check_kind,
    check_number,
    check_whole,
)
from ..base.errors import BadInput
from ..base.vectors import Array, number_array

# Fields that may be uncertain, and what they follow: the stalled torque S, the motor's line S / w0,
# or nothing. The sigma of those that follow says how uncertain the ratio is.
UNCERTAIN = {
    "torque_limit_nm": "",
    "speed_limit_rad_s": "",
    "stiffness_nm_rad": "torque",
    "gear_friction_nm": "torque",
    "damping_nms_rad": "line",
    "gear_damping_nms_rad": "line",
    "armature_kg_m2": "line",
    "dead_band_rad": "",
    "supply_sag": "",
    "supply_v": "",
}
REMOVED = {  # a field of older files, and what to do where it is not 0
    "backlash_rad": "serpenoid no longer has play in gears; remove the line for a gear without play"
}
FRAME_S = 0.02  # frame of a board with up to seven joints


@dataclass(frozen=True)
class SoldServos:
    """Bounds of servos that are sold; what is drawn beyond them is drawn anew.

    friction: dry friction of the gear over the stalled torque; servos have 0.015 to 0.13. loss: the
    motor's free speed over the servo's no-load speed. beyond_typical: a source may say more; then
    either bound is so many times the typical servo's value. loop_radius: above it a loop hunts.
    tries: draws for each servo that is wanted.
    """

    friction: float = 0.15
    loss: float = 2.0
    beyond_typical: float = 1.5
    loop_radius: float = 0.97
    tries: int = 100


SOLD = SoldServos()


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

    Examples
    --------
    >>> table = sn.TorqueTable([0.0, 1.0], [[0.0, 0.0], [0.02, -0.01]])
    >>> table.torque_nm.shape
    (2, 2)
    """

    t_s: Array
    torque_nm: Array

    def __post_init__(self) -> None:
        t, T = number_array("t_s", self.t_s), number_array("torque_nm", self.torque_nm)
        fits = t.size > 0 and t.shape == (t.size,) == T.shape[:-1]
        if not (fits and np.isfinite(t).all() and np.isfinite(T).all() and np.all(np.diff(t) > 0)):
            raise BadInput(
                "a torque table needs finite torque_nm (K, n-1) at finite, rising t_s (K,); got "
                f"{T.shape} at {t.shape}"
            )
        object.__setattr__(self, "t_s", t)
        object.__setattr__(self, "torque_nm", T)


@dataclass(frozen=True, slots=True)
class Servo:
    """Describe the servos of all joints: position loop, motor, gear, supply.

    The defaults are round numbers for a servo of 6 V (0.3 N m, 60 degrees in 0.12 s) without rotor
    and gear, which no real one lacks: `sn.servo()` has those of real ones.

    Attributes
    ----------
    stiffness_nm_rad
        K of the position loop, N m/rad.
    damping_nms_rad
        D of the position loop, N m s/rad.
    torque_limit_nm
        Stalled torque S of the motor, at the joint, N m.
    speed_limit_rad_s
        Free speed w0 of the motor, at the joint, rad/s.
    dead_band_rad
        The loop's error counts from here on, rad.
    armature_kg_m2
        The rotor's inertia times the gear ratio squared, kg m^2.
    gear_friction_nm
        Dry friction of the gear, N m.
    gear_damping_nms_rad
        Viscous friction of the gear, N m s/rad.
    update_hz
        How often the loop looks, Hz, on the clock of the frames; 0: at all times.
    supply_sag
        Share of the supply's voltage that one stalled servo takes.
    frame_s
        Time from one setpoint to the next, s; setpoints are the firmware's, in fixed point.
    supply_v
        Voltage at the plug for which torque and speed hold, V; 0: not stated.

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

    A data sheet measures the whole servo, with its gear: `stall_torque_nm` is S - f and
    `no_load_rad_s` is (S - f) / (S / w0 + c), with the gear's dry friction f and damping c.

    Examples
    --------
    >>> quick = sn.Servo(speed_limit_rad_s=12.0, update_hz=300.0)
    >>> quick.speed_limit_rad_s
    12.0
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
    frame_s: float = FRAME_S
    supply_v: float = 0.0

    def __post_init__(self) -> None:
        limits = {
            "torque_limit_nm": POSITIVE,
            "speed_limit_rad_s": POSITIVE,
            "update_hz": Limits(0.0, 1e4),
            "supply_sag": Limits(0.0, 1.0),
            "frame_s": Limits(0.0, 0.1, open_low=True),
        }
        check_fields(self, dict.fromkeys(self.__slots__, NOT_NEGATIVE) | limits)

    @property
    def stall_torque_nm(self) -> float:
        """Return the torque that the whole servo gives when it is held, N m."""
        return self.torque_limit_nm - self.gear_friction_nm

    @property
    def no_load_rad_s(self) -> float:
        """Return how fast the whole servo turns without load, rad/s."""
        line = self.torque_limit_nm / self.speed_limit_rad_s
        return max(self.stall_torque_nm, 0.0) / (line + self.gear_damping_nms_rad)

    def at_volts(self, supply_v: float) -> Servo:
        """Return the servo with another voltage at its plug.

        Stalled torque, free speed and stiffness follow the voltage. The motor's line S / w0, and
        so damping, and all of the gear stay.

        Parameters
        ----------
        supply_v
            The voltage, V.

        Returns
        -------
        Servo
            The servo there.

        Raises
        ------
        BadInput
            For no voltage above 0, and for a servo whose values are for no stated one.
        """
        check_number("supply_v", supply_v, 0.0, open_low=True)
        if self.supply_v == 0:
            raise BadInput(
                f"the servo cannot be taken to {supply_v:g} V: nothing says for which voltage its "
                "values hold; give it supply_v"
            )
        ratio = supply_v / self.supply_v
        return replace(
            self,
            stiffness_nm_rad=ratio * self.stiffness_nm_rad,
            torque_limit_nm=ratio * self.torque_limit_nm,
            speed_limit_rad_s=ratio * self.speed_limit_rad_s,
            supply_v=supply_v,
        )


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
        one are exact. Those of torque_limit_nm and speed_limit_rad_s are of the whole servo, as a
        data sheet has it: of `Servo.stall_torque_nm` and `Servo.no_load_rad_s`. Stiffness and gear
        friction are drawn as ratios to the motor's stalled torque; damping, gear damping and rotor
        as ratios to its torque over its speed. supply_v: of the voltage at the plug; its logarithm
        is evenly spread, within sqrt(3) standard deviations. All others are normal.
    updates_hz
        Rates at which loops of this kind may look, Hz, each as likely; () for the typical one's.
    source
        Where the values come from.
    drawn
        Servos that a measurement leaves possible, each as likely; if any, no others are drawn.
    remark
        Why it is not to be trusted: the model of a servo does not describe what was measured.

    Raises
    ------
    BadInput
        For values out of range and names that Servo does not have.

    Examples
    --------
    >>> kind = sn.servo("hobby")
    >>> kind.name, kind.exact
    ('hobby', False)
    """

    name: str
    servo: Servo
    sigma: Mapping[str, float] = field(default_factory=dict)
    updates_hz: tuple[float, ...] = ()
    source: str = ""
    drawn: tuple[Servo, ...] = ()
    remark: str = ""

    def __post_init__(self) -> None:
        for servo in (self.servo, *self.drawn):
            check_kind("servo", servo, Servo)
        for name, value in self.sigma.items():
            check_choice("sigma", name, tuple(UNCERTAIN))
            check_number(f"sigma of {name}", value, 0.0, 3.0)
        if self.sigma.get("supply_v") and not self.servo.supply_v:
            raise BadInput("sigma has supply_v, but the servo has none; give it supply_v, V")
        if not self.exact and self.servo.stall_torque_nm <= 0:
            raise BadInput(
                f"gear_friction_nm is {self.servo.gear_friction_nm:g}; it must be below "
                f"torque_limit_nm, {self.servo.torque_limit_nm:g}: else no servo moves"
            )
        for rate in self.updates_hz:
            check_number("updates_hz", rate, 0.0, 1e4)
        object.__setattr__(self, "sigma", MappingProxyType(dict(self.sigma)))

    @property
    def exact(self) -> bool:
        """Tell whether nothing is in doubt."""
        doubt = any(self.sigma.values()) or len(self.updates_hz) > 1
        return not doubt and len(self.drawn) <= 1

    @property
    def volts_in_words(self) -> str:
        """Return the voltages at the plug that are drawn, and whether anybody measured them."""
        spread = math.exp(math.sqrt(3) * self.sigma.get("supply_v", 0.0))
        low, high = self.servo.supply_v / spread, self.servo.supply_v * spread
        drawn = f"{low:.3g} to {high:.3g}: not measured" if spread > 1 else f"{low:.3g}"
        return drawn if low else "not stated"

    def at_volts(self, supply_v: float) -> ServoKind:
        """Return the kind with a voltage at the plug that is known.

        Parameters
        ----------
        supply_v
            The voltage, V.

        Returns
        -------
        ServoKind
            The kind, with no doubt about the voltage.

        Raises
        ------
        BadInput
            As `Servo.at_volts`.
        """
        sigma = {name: value for name, value in self.sigma.items() if name != "supply_v"}
        return replace(self._with_servos(lambda servo: servo.at_volts(supply_v)), sigma=sigma)

    def _with_servos(self, changed: Callable[[Servo], Servo]) -> ServoKind:
        """Return the kind with the typical and all drawn servos changed."""
        return replace(self, servo=changed(self.servo), drawn=tuple(map(changed, self.drawn)))

    def at_frames(self, frame_s: float) -> ServoKind:
        """Return the kind on a board with another time between setpoints.

        Parameters
        ----------
        frame_s
            From setpoint to setpoint, s.

        Returns
        -------
        ServoKind
            The kind on that board.

        Raises
        ------
        BadInput
            For a time outside of 0 to 0.1 s.
        """
        return self._with_servos(lambda servo: replace(servo, frame_s=frame_s))

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
            For a count that is no whole number of 1 or more, and for a kind of which no servo is
            possible.
        """
        check_whole("count", count, 1)
        rng = np.random.default_rng(seed)
        if self.drawn:
            times = -(-count // len(self.drawn))
            order = np.concatenate([rng.permutation(len(self.drawn)) for _ in range(times)])
            return [self.drawn[k] for k in order[:count].tolist()]
        if self.exact:
            rates = (*self.updates_hz, self.servo.update_hz)
            return [replace(self.servo, update_hz=rates[0])] * count
        return self._sold(count, rng.random(len(UNCERTAIN) + 1))

    def _sold(self, count: int, shift: Array) -> list[Servo]:
        """Return servos evenly spread over the doubt: a lattice's points, shifted at random.

        The lattice is the one that powers of an irrational number make (Roberts, 2018).
        """
        irrational = 2.0
        for _ in range(64):  # x^(d + 1) = x + 1
            irrational = (1.0 + irrational) ** (1.0 / (len(shift) + 1))
        step = irrational ** -np.arange(1.0, len(shift) + 1)
        rates = self.updates_hz or (self.servo.update_hz,)
        normal, sold = NormalDist(), []
        for k in range(SOLD.tries * count):
            *even, rate = np.clip((shift + k * step) % 1.0, 1e-12, 1 - 1e-12).tolist()
            units = [normal.inv_cdf(x) for x in even]
            servo = self._servo_of(units, rates[int(rate * len(rates))])
            if servo is not None:
                sold.append(servo)
            if len(sold) == count:
                return sold
        raise BadInput(
            f"servo {self.name!r}: too few of {SOLD.tries * count} drawn ones are possible: their "
            "loops hunt, or their gears take too much; look at stiffness_nm_rad and sigma"
        )

    def _servo_of(self, units: Sequence[float], update_hz: float) -> Servo | None:
        """Return the servo whose UNCERTAIN values lie off the typical ones by units, in sigma.

        None if no such servo is sold: its loop hunts, its gear's friction is above 0.15 S, or its
        motor's free speed is above twice its no-load speed (or what the typical one has, and half
        as much again). Units are independent and normal, but for that. update_hz: of the loop, Hz.

        With f = q S and c = g S / w0 the whole servo's torque T = S - f and no-load speed
        w = (S - f) / (S / w0 + c) give S = T / (1 - q) and w0 = w (1 + g) / (1 - q).
        """
        *normal, plug = units
        even = math.sqrt(3) * math.erf(plug / math.sqrt(2))
        scales = _scales(self.servo.torque_limit_nm, self.servo.speed_limit_rad_s)
        typical = {
            name: getattr(self.servo, name) / scales[scale] for name, scale in UNCERTAIN.items()
        }
        typical["torque_limit_nm"] = self.servo.stall_torque_nm
        typical["speed_limit_rad_s"] = self.servo.no_load_rad_s
        values = {
            name: typical[name] * math.exp(self.sigma.get(name, 0.0) * x)
            for name, x in zip(UNCERTAIN, (*normal, even), strict=True)
        }
        friction, loss = values["gear_friction_nm"], _loss(values)
        if friction > max(SOLD.friction, SOLD.beyond_typical * typical["gear_friction_nm"]):
            return None
        if loss > max(SOLD.loss, SOLD.beyond_typical * _loss(typical)):
            return None
        torque = values["torque_limit_nm"] / (1 - friction)
        speed = values["speed_limit_rad_s"] * loss
        values |= {"torque_limit_nm": torque, "speed_limit_rad_s": speed}
        scales = _scales(torque, speed)
        values = {name: value * scales[UNCERTAIN[name]] for name, value in values.items()}
        values["supply_sag"] = min(values["supply_sag"], 1.0)
        supply_v = values.pop("supply_v")
        servo = replace(self.servo, **values, update_hz=update_hz)
        if self.sigma.get("supply_v"):
            servo = servo.at_volts(supply_v)
        return None if loop_radius(servo) >= SOLD.loop_radius else servo


def _loss(ratios: Mapping[str, float]) -> float:
    """Return the motor's free speed over the whole servo's no-load speed."""
    return (1 + ratios["gear_damping_nms_rad"]) / (1 - ratios["gear_friction_nm"])


def _scales(torque_nm: float, speed_rad_s: float) -> dict[str, float]:
    """Return what UNCERTAIN fields follow, by its values there."""
    return {"": 1.0, "torque": torque_nm, "line": torque_nm / speed_rad_s}


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
    spring, damper = servo.stiffness_nm_rad / J, (servo.damping_nms_rad - line) / J
    by_duty = np.outer((drift, glide), (spring, damper))
    look_to_look = np.array([[1.0, glide], [0.0, decay]]) - by_duty
    return float(np.abs(np.linalg.eigvals(look_to_look)).max()) ** (FRAME_S / look)
