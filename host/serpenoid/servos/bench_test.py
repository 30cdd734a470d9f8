"""A servo from a test of one joint: setpoints that were sent, and the angles that were seen.

Servos of a kind are drawn, and those kept that would have moved so. A sequential Monte Carlo
sampler goes from the kind's doubt to what the readings leave of it, by rising powers of the
likelihood, with Metropolis steps. All servos step through the test side by side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..model.checks import check_number
from ..model.drives import UNCERTAIN, Servo, ServoKind
from ..model.errors import BadInput
from ..model.vectors import finite_vector

Array = NDArray[np.float64]
PARTICLES, MOVES, KEPT = 192, 4, 48
_STEP_S, _MOST_STEPS, _MOST_DELAY_S = 1e-3, 20_000, 0.03
_STRIDE, _MOST_POWERS = 0.6, 40
_NEVER = -1e9  # a log likelihood
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


@dataclass(frozen=True)
class MeasuredServo:
    """What a measurement leaves of a kind. told, untold: fields, with the sigma of their logarithm
    before and after it. chi2: of the best servo, over `readings`."""

    kind: ServoKind
    told: dict[str, tuple[float, float]]
    untold: tuple[str, ...]
    chi2: float
    readings: int

    def to_dict(self) -> dict[str, Any]:
        """Return plain values."""
        servo = {name: getattr(self.kind.servo, name) for name in _FIELDS}
        return {
            "name": self.kind.name,
            "servo": servo,
            "chi2": self.chi2,
            "readings": self.readings,
            "told": {n: {"before": a, "after": b} for n, (a, b) in self.told.items()},
            "untold": list(self.untold),
        }


def moved(test: BenchTest, servos: list[Servo], delay_s: Array) -> Array:
    """Return the angles (K, T) that each servo would have shown; delay_s: until it hears."""
    columns = {name: np.array([getattr(s, name) for s in servos]) for name in _FIELDS}
    K, D, S, w0, band, J, dry, c, hz, sag = columns.values()
    h, steps = _STEP_S, math.ceil(np.ptp(test.t_s) / _STEP_S) + 1
    times = test.t_s[0] + h * np.arange(steps + 1)
    heard = times[:, None] - delay_s
    at = np.searchsorted(test.t_s, heard.ravel(), side="right").reshape(heard.shape) - 1
    setpoints = test.setpoint_rad[np.maximum(at, 0)]
    looks = np.ones(heard.shape, dtype=bool)
    looks[1:] = (hz == 0) | (np.diff(np.floor((heard - test.t_s[0]) * hz), axis=0) != 0)
    spring, damper = K / S, D / S - 1 / w0
    # implicit in the rate: the motor's line, and the gear's friction, which never turns it round
    inert = J + test.inertia_kg_m2
    mass = inert + h * (S / w0 + c)
    slows, drives, holds = inert / mass, h * S / mass, h * dry / mass
    angle, rate, duty = np.full(len(K), test.angle_rad[0]), np.zeros(len(K)), np.zeros(len(K))
    seen = np.empty(heard.shape)
    for k in range(steps + 1):
        seen[k] = angle
        if looks[k].any():
            off = setpoints[k] - angle
            off -= np.minimum(np.maximum(off, -band), band)
            asked = np.minimum(np.maximum(spring * off - damper * rate, -1.0), 1.0)
            duty = np.where(looks[k], asked, duty)
        # the one joint's load on the supply; the others rest
        supply = (1.0 + sag / w0 * duty * rate) / (1.0 + sag * duty * duty)
        rate = slows * rate + drives * duty * np.minimum(np.maximum(supply, 0.0), 1.0)
        rate = rate - np.minimum(np.maximum(rate, -holds), holds)
        angle = angle + h * rate
    return np.array([np.interp(test.t_s, times, column) for column in seen.T])


class _Sampler:
    """Servos as unknowns of the kind's doubt: one normal each field, a delay, a rate of looking."""

    def __init__(self, test: BenchTest, kind: ServoKind, seed: int):
        self.test, self.kind, self.rng = test, kind, np.random.default_rng(seed)
        self.rates = kind.updates_hz or (kind.servo.update_hz,)
        self.free = [k for k, n in enumerate(UNCERTAIN) if kind.sigma.get(n, 0.0) > 0]

    def servos(self, x: Array, rate: NDArray[np.intp]) -> list[Servo | None]:
        """Return the servo of each row; None where no such servo is sold."""
        return [
            self.kind.at(row[:-1].tolist(), self.rates[k]) for row, k in zip(x, rate, strict=True)
        ]

    def log_likely(self, x: Array, rate: NDArray[np.intp]) -> Array:
        from scipy.special import ndtr

        servos = self.servos(x, rate)
        sold = [k for k, servo in enumerate(servos) if servo is not None]
        delay_s = _MOST_DELAY_S * ndtr(x[sold, -1])
        off = moved(self.test, list(filter(None, servos)), delay_s) - self.test.angle_rad
        likely = np.full(len(x), _NEVER)
        likely[sold] = -0.5 * np.sum((off / self.test.sigma_rad) ** 2, axis=1)
        return np.nan_to_num(likely, nan=_NEVER)

    def run(self) -> tuple[Array, NDArray[np.intp], Array]:
        """Return unknowns, rates and log likelihoods of servos that the test leaves possible."""
        x, rate = self._start()
        likely, power = self.log_likely(x, rate), 0.0
        for _ in range(_MOST_POWERS):
            power, weight = self._next(likely, power)
            pick = self.rng.choice(PARTICLES, PARTICLES, p=weight)
            x, rate, likely = x[pick], rate[pick], likely[pick]
            for _ in range(MOVES):
                x, rate, likely = self._move(x, rate, likely, power)
            if power >= 1.0:
                break
        return x, rate, likely

    def _start(self) -> tuple[Array, NDArray[np.intp]]:
        """Return unknowns and rates of drawn servos, the delay last."""
        servos = self.kind.draws(PARTICLES, int(self.rng.integers(2**31)))
        units = [self.kind.units_of(one) for one in servos]
        x = np.column_stack([units, self.rng.normal(size=PARTICLES)])
        return x, np.array([self.rates.index(one.update_hz) for one in servos])

    def _next(self, likely: Array, power: float) -> tuple[float, Array]:
        """Return the next power, at which half the servos still count, and their weights."""

        def weights(to: float) -> Array:
            w = np.exp((to - power) * (likely - likely.max()))
            return w / w.sum()

        low, high = power, 1.0
        if 1 / np.sum(weights(1.0) ** 2) < PARTICLES / 2:
            for _ in range(40):
                middle = (low + high) / 2
                enough = 1 / np.sum(weights(middle) ** 2) > PARTICLES / 2
                low, high = (middle, high) if enough else (low, middle)
        return high, weights(high)

    def _move(
        self, x: Array, rate: NDArray[np.intp], likely: Array, power: float
    ) -> tuple[Array, NDArray[np.intp], Array]:
        """Take a Metropolis step along the difference of two others, or draw one field anew.

        A field that the test does not tell (the torque of a joint without load) then stays free.
        """
        one, other = (x[self.rng.permutation(PARTICLES)] for _ in range(2))
        stride = _STRIDE * self.rng.choice([0.3, 1.0, 1.6], size=(PARTICLES, 1))
        jitter = np.zeros_like(x)
        jitter[:, [*self.free, x.shape[1] - 1]] = 0.02
        to = x + stride * (one - other) + jitter * self.rng.normal(size=x.shape)
        anew = self.rng.uniform(size=PARTICLES) < 0.3
        to[anew] = x[anew]
        to[anew, self.rng.choice(self.free, anew.sum())] = self.rng.normal(size=anew.sum())
        swap = self.rng.integers(len(self.rates), size=PARTICLES)
        new_rate = np.where(self.rng.uniform(size=PARTICLES) < 0.2, swap, rate)
        new = self.log_likely(to, new_rate)
        gain = power * (new - likely)
        gain -= np.where(anew, 0.0, 0.5 * (np.sum(to**2, axis=1) - np.sum(x**2, axis=1)))
        take = np.log(self.rng.uniform(size=PARTICLES)) < gain
        return (
            np.where(take[:, None], to, x),
            np.where(take, new_rate, rate),
            np.where(take, new, likely),
        )


def servo_of_test(
    test: BenchTest, like: ServoKind, *, name: str = "measured", seed: int = 0
) -> MeasuredServo:
    """Return what a test of one joint leaves of a kind of servo. Raises BadInput."""
    if like.exact or like.drawn:
        raise BadInput(
            f"servo {like.name!r} has no doubt to fit in; take `hobby`, or a data sheet's"
        )
    sampler = _Sampler(test, like, seed)
    x, rate, likely = sampler.run()
    servos = sampler.servos(x, rate)
    best = int(np.argmax(likely))
    order = np.random.default_rng(seed).permutation(PARTICLES)[:KEPT]
    source = f"a bench test of one joint, from {like.name}"
    kept = tuple(filter(None, (servos[k] for k in order)))
    return measured_servo(
        like,
        servos[best] or like.servo,
        kept,
        name,
        source,
        -2 * float(likely[best]),
        test.t_s.size,
    )


def measured_servo(
    like: ServoKind,
    best: Servo,
    kept: tuple[Servo, ...],
    name: str,
    source: str,
    chi2: float,
    readings: int,
) -> MeasuredServo:
    """Return the kind that some servos make, and which fields the measurement has told."""
    names = [n for n in UNCERTAIN if like.sigma.get(n, 0.0) > 0]
    before = _sigmas(like.draws(512), names)
    after = _sigmas(list(kept), names)
    told = {n: (before[n], after[n]) for n in names if after[n] < 0.6 * before[n]}
    kind = ServoKind(name, best, {}, (), source, kept)
    return MeasuredServo(kind, told, tuple(n for n in names if n not in told), chi2, readings)


def _sigmas(servos: list[Servo], names: list[str]) -> dict[str, float]:
    return {n: float(np.std(np.log([max(getattr(s, n), 1e-12) for s in servos]))) for n in names}
