"""A servo from a test of one joint: setpoints that were sent, and the angles that were seen.

Servos of a kind are drawn, and those kept that would have moved so: tempered particles go from the
kind's doubt to what the readings leave of it. All servos step through the test side by side.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..model.checks import check_number
from ..model.drives import UNCERTAIN, Servo, ServoKind
from ..model.errors import BadInput
from ..model.particles import tempered
from ..model.vectors import finite_vector

Array = NDArray[np.float64]
PARTICLES, MOVES, KEPT = 768, 10, 128
_STEP_S, _MOST_STEPS, _MOST_DELAY_S = 1e-3, 20_000, 0.03
_SAME_S = 1e-9  # a look at a setpoint's time has it
_NEVER = 2e9  # a sum of squares
_EXACT = 1e-9  # a sigma
_FIELDS = (
    "stiffness_nm_rad",
    "damping_nms_rad",
    "torque_limit_nm",
    "speed_limit_rad_s",
    "dead_band_rad",
    "armature_kg_m2",
    "gear_friction_nm",
    "gear_damping_nms_rad",
    "update_hz",
    "supply_sag",
)


@dataclass(frozen=True)
class BenchTest:
    """Hold what was sent to one joint and seen of it, the joint free of all other loads.

    t_s (T,), rising; setpoint_rad (T,), each held until the next time; angle_rad (T,), with the
    standard deviation sigma_rad. inertia_kg_m2: of what the servo turns. Raises BadInput.
    """

    t_s: Array
    setpoint_rad: Array
    angle_rad: Array
    sigma_rad: float = math.radians(0.5)
    inertia_kg_m2: float = 0.0

    def __post_init__(self) -> None:
        for name in ("t_s", "setpoint_rad", "angle_rad"):
            given: ArrayLike = getattr(self, name)
            count = np.size(given)
            object.__setattr__(self, name, np.array(finite_vector(name, given, count), dtype=float))
        if len({self.t_s.size, self.setpoint_rad.size, self.angle_rad.size}) != 1:
            raise BadInput("t_s, setpoint_rad and angle_rad must have one value each row")
        if self.t_s.size < 10 or not (np.diff(self.t_s) > 0).all():
            raise BadInput(
                f"a bench test needs 10 rows or more at rising times; got {self.t_s.size}"
            )
        if np.ptp(self.t_s) > _STEP_S * _MOST_STEPS:
            raise BadInput(f"the test lasts {np.ptp(self.t_s):.3g} s; give 20 s at most")
        if np.ptp(self.setpoint_rad) == 0:
            raise BadInput("the setpoint never changes; send a step, or a gait")
        check_number("sigma_rad", self.sigma_rad, 0.0, 1.0, open_low=True)
        check_number("inertia_kg_m2", self.inertia_kg_m2, 0.0)


class Shown(NamedTuple):
    """The median of a value, its 95 % interval, and what sigma its logarithm had and has."""

    value: float
    low: float
    high: float
    before: float
    after: float

    @property
    def told(self) -> bool:
        """Tell whether the measurement says much of it."""
        return self.after < 0.6 * self.before - _EXACT


@dataclass(frozen=True)
class MeasuredServo:
    """What a measurement leaves of a kind.

    shown: by the names of `shown`. chi2: of kind.servo, over `readings`.
    """

    kind: ServoKind
    shown: dict[str, Shown]
    chi2: float
    readings: int

    @property
    def untold(self) -> list[str]:
        """Return the names of what the measurement hardly says."""
        return [n for n, one in self.shown.items() if one.before > _EXACT and not one.told]

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        return {
            "name": self.kind.name,
            "servo": asdict(self.kind.servo),
            "chi2": self.chi2,
            "readings": self.readings,
            "told": {name: one._asdict() for name, one in self.shown.items() if one.told},
            "untold": self.untold,
        }


def shown(servo: Servo) -> dict[str, float]:
    """Return what measurements show of a servo: of the whole one, most of it as a ratio.

    A joint without load shows no torque. What brakes it, motor and gear, it shows only together,
    and its speed on a supply that sags: by S (1 - r / w0) / (1 + supply_sag) at the whole duty.
    """
    torque = servo.torque_limit_nm
    line = torque / servo.speed_limit_rad_s
    sagging = replace(servo, torque_limit_nm=torque / (1 + servo.supply_sag))
    return {
        "no_load_rad_s": sagging.no_load_rad_s,
        "stall_torque_nm": servo.stall_torque_nm,
        "stiffness_over_torque": servo.stiffness_nm_rad / torque,
        "rotor_over_brake_s": servo.armature_kg_m2 / (line + servo.gear_damping_nms_rad),
        "gear_friction_over_torque": servo.gear_friction_nm / torque,
        "gear_damping_over_motors": servo.gear_damping_nms_rad / line,
        "dead_band_rad": servo.dead_band_rad,
        "supply_sag": servo.supply_sag,
        "supply_v": servo.supply_v,
    }


def moved(test: BenchTest, servos: list[Servo], delay_s: Array) -> Array:
    """Return the angles (K, T) that each servo would have shown; delay_s: after the row."""
    fields = np.array([[getattr(s, name) for name in _FIELDS] for s in servos])
    K, D, S, w0, band, J, dry, c, hz, sag = fields.T
    h, steps = _STEP_S, math.ceil(np.ptp(test.t_s) / _STEP_S) + 1
    times = test.t_s[0] + h * np.arange(steps + 1)
    # a step may have a look inside it: when, and what is asked there
    hz = np.where(hz > 0, hz, 1 / h)
    heard = times[1:, None] - delay_s + _SAME_S
    since = (heard - test.t_s[0]) % (1 / hz)
    looks, shares = since < h, since / h
    at = np.searchsorted(test.t_s, (heard - since + _SAME_S).ravel(), side="right") - 1
    setpoints = test.setpoint_rad[np.maximum(at, 0)].reshape(heard.shape)
    spring, damper = K / S, D / S - 1 / w0
    # the motor's line is solved for exactly, and the gear's friction never turns the rate round
    line = S / w0 + c
    slows = np.exp(-h * line / np.maximum(J + test.inertia_kg_m2, 1e-12))
    drives, holds = (1 - slows) * S / line, (1 - slows) * dry / line
    angle, rate, duty = np.full(len(K), test.angle_rad[0]), np.zeros(len(K)), np.zeros(len(K))
    angles = np.tile(angle, (steps + 1, 1))
    for k in range(steps):
        off = setpoints[k] - angle - (1 - shares[k]) * h * rate
        off -= np.minimum(np.maximum(off, -band), band)
        asked = np.minimum(np.maximum(spring * off - damper * rate, -1.0), 1.0)
        mean_duty = np.where(looks[k], duty + shares[k] * (asked - duty), duty)
        duty = np.where(looks[k], asked, duty)
        # the one joint's load on the supply; the others rest
        supply = (1.0 + sag / w0 * mean_duty * rate) / (1.0 + sag * mean_duty * mean_duty)
        before = rate
        rate = slows * rate + drives * mean_duty * np.minimum(np.maximum(supply, 0.0), 1.0)
        rate = rate - np.minimum(np.maximum(rate, -holds), holds)
        angle = angle + h / 2 * (before + rate)
        angles[k + 1] = angle
    return np.array([np.interp(test.t_s, times, column) for column in angles.T])


class _Posterior:
    """Servos as unknowns: the kind's units of the fields in doubt, a delay, a rate of looking.

    Two of them differ from the kind's. A joint shows its rotor over all that brakes it, motor and
    gear, and its speed at the voltage of the test. So these are the unknowns: what a joint does not
    show (the gear's damping alone, the voltage) then bends the scatter of no other.
    """

    def __init__(self, test: BenchTest, kind: ServoKind):
        self.test, self.kind = test, kind
        self.rates = kind.updates_hz or (kind.servo.update_hz,)
        self.free = [kind.sigma.get(name, 0.0) > 0 for name in UNCERTAIN] + [True, True]

    def units(self, x: Array) -> Array:
        """Return the kind's units (K, fields), and those of delay and rate, of unknowns (K, D)."""
        from scipy.special import erf

        units, sigma = np.zeros((len(x), len(self.free))), self.kind.sigma
        units[:, self.free] = x
        unit = dict(zip(map(str, UNCERTAIN), units.T, strict=False))
        volts = sigma.get("supply_v", 0.0) * math.sqrt(3) * erf(unit["supply_v"] / math.sqrt(2))
        gear = np.exp(sigma.get("gear_damping_nms_rad", 0.0) * unit["gear_damping_nms_rad"])
        brake = np.log1p(shown(self.kind.servo)["gear_damping_over_motors"] * gear)
        for name, logarithm in (("speed_limit_rad_s", -volts), ("armature_kg_m2", brake)):
            if sigma.get(name):
                unit[name] += logarithm / sigma[name]
        return units

    def servos(self, units: Array) -> list[Servo | None]:
        """Return the servo of each row of units; None where no such servo is sold."""
        from scipy.special import ndtr

        rate = np.minimum(len(self.rates) * ndtr(units[:, -1]), len(self.rates) - 1).astype(int)
        pairs = zip(units[:, :-2].tolist(), rate.tolist(), strict=True)
        return [self.kind.at(row, self.rates[k]) for row, k in pairs]

    def chi2(self, units: Array) -> Array:
        """Return the sum of squares over the readings; _NEVER where no such servo is sold."""
        from scipy.special import erf

        servos = self.servos(units)
        tried = [servo or self.kind.servo for servo in servos]
        # below 0: a row has its setpoint late, or lies between two looks
        delay_s = _MOST_DELAY_S * erf(units[:, -2] / math.sqrt(2))
        off = moved(self.test, tried, delay_s) - self.test.angle_rad
        squares = np.nan_to_num(np.sum(off**2, axis=1) / self.test.sigma_rad**2, nan=_NEVER)
        return np.where([servo is None for servo in servos], _NEVER, squares)

    def log_ratio(self, x: Array) -> Array:
        """Return the logarithm of the density that the test leaves over the one before it."""
        units = self.units(x)
        return log_normal(units) - log_normal(x) - 0.5 * self.chi2(units)


def log_normal(x: Array) -> Array:
    """Return the logarithm of the normal density, but for its constant."""
    return np.asarray(-0.5 * np.sum(x**2, axis=1))


def servo_of_test(
    test: BenchTest, like: ServoKind, *, name: str = "measured", seed: int = 0
) -> MeasuredServo:
    """Return what a test of one joint leaves of a kind of servo. Raises BadInput."""
    if like.exact or like.drawn:
        raise BadInput(
            f"servo {like.name!r} has no doubt to fit in; take `hobby`, or a data sheet's"
        )
    rng, posterior = np.random.default_rng(seed), _Posterior(test, like)
    x = rng.normal(size=(PARTICLES, sum(posterior.free)))
    x = tempered(x, log_normal, posterior.log_ratio, rng, MOVES)[0]
    units = posterior.units(x)
    servos, chi2 = posterior.servos(units), posterior.chi2(units)
    middle = int(np.argmin(np.sum((x - x.mean(axis=0)) ** 2 / x.var(axis=0), axis=1)))
    kept = tuple(filter(None, (servos[k] for k in rng.permutation(PARTICLES)[:KEPT])))
    return measured_servo(
        like,
        servos[middle] or like.servo,
        kept,
        name,
        f"a bench test of one joint, from {like.name}",
        float(chi2[middle]),
        test.t_s.size,
    )


def measured_servo(
    like: ServoKind,
    typical: Servo,
    kept: tuple[Servo, ...],
    name: str,
    source: str,
    chi2: float,
    readings: int,
) -> MeasuredServo:
    """Return the kind that some servos make, and what is known of them."""
    prior, drawn = _logarithms(like.draws(512)), _logarithms(list(kept))
    middle = np.exp(np.quantile(drawn, (0.5, 0.025, 0.975), axis=0))
    rows = np.vstack([middle, prior.std(axis=0), drawn.std(axis=0)]).T.tolist()
    values = {name: Shown(*row) for name, row in zip(shown(typical), rows, strict=True)}
    return MeasuredServo(ServoKind(name, typical, {}, (), source, kept), values, chi2, readings)


def _logarithms(servos: list[Servo]) -> Array:
    return np.log(np.maximum([list(shown(servo).values()) for servo in servos], 1e-12))
