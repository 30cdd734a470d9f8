"""A bench test of one joint: the table, and a servo's parameters under which a joint moves so.

A parameter is counted in standard deviations of its prior, so that all are standard normal before
the test. Torques are relative to the motor's stalled torque unless the joint turns a known load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.checks import check_number
from ..base.errors import BadInput
from ..model.drives import Servo, ServoKind

Array = NDArray[np.float64]
Values = dict[str, Array]
GRAVITY_M_S2 = 9.81
MIN_ROWS, MAX_TEST_S = 10, 20.0
MAX_LOAD_KG, MAX_LOAD_M = 5.0, 1.0  # their torque, 49 N m, is ten times that of a large hobby servo
MIN_GAIN, MAX_GAIN = 0.1, 1.7  # degrees of the angle for one of the setpoint, of a sound table
MIN_SPAN_RAD = math.radians(4.0)  # span of setpoints: less is within dead bands and teeth
MAX_STEPS = 40  # steps with a delay of their own; a gait has more setpoints, which share one delay


@dataclass(frozen=True)
class Load:
    """A mass at a distance from the axis, which hangs straight down at the angle down_rad.

    level: whether the axis is level, so that gravity turns it; else the load is an inertia alone.
    """

    mass_kg: float
    distance_m: float
    level: bool = True
    down_rad: float = 0.0

    def __post_init__(self) -> None:
        check_number("mass_kg", self.mass_kg, 0.0, MAX_LOAD_KG, open_low=True)
        check_number("distance_m", self.distance_m, 0.0, MAX_LOAD_M, open_low=True)


@dataclass(frozen=True)
class BenchTest:
    """What was sent to one joint, and the angles that were seen.

    t_s (T,), rising; setpoint_rad (T,), each held until the next time; angle_rad (T,), with the
    standard deviation sigma_rad; None: the table's own scatter. sent_s (T,): when the row's
    setpoint was sent, by the host's clock; None for the row's time. Raises BadInput.
    """

    t_s: Array
    setpoint_rad: Array
    angle_rad: Array
    sigma_rad: float | None = None
    load: Load | None = None
    sent_s: Array | None = None

    def __post_init__(self) -> None:
        rows = self.t_s.size
        if rows < MIN_ROWS or not (np.diff(self.t_s) > 0).all():
            raise BadInput(
                f"a bench test needs {MIN_ROWS} rows or more at rising times; got {rows}"
            )
        lasts_s = float(np.ptp(self.t_s))
        if lasts_s > MAX_TEST_S:
            raise BadInput(f"the test lasts {lasts_s:.3g} s; give {MAX_TEST_S:.0f} s at most")
        span_rad = float(np.ptp(self.setpoint_rad))
        if span_rad < MIN_SPAN_RAD:
            raise BadInput(
                f"the setpoints span {math.degrees(span_rad):.2g} degrees, which shows nothing; "
                f"send steps of {math.degrees(MIN_SPAN_RAD):.0f} or more, or a gait. If these are "
                "radians, write degrees"
            )

    @property
    def resolution_rad(self) -> float:
        """Return the smallest difference between two angles of the table."""
        steps = np.diff(np.unique(np.round(self.angle_rad, 9)))
        return float(steps.min()) if steps.size else 0.0

    @property
    def noise_rad(self) -> float:
        """Return the standard deviation of an angle: as stated, or by its second differences.

        The resolution of the table is in it. The median leaves the rows out in which the joint
        comes to speed or stops.
        """
        if self.sigma_rad is not None:
            return self.sigma_rad
        second = np.abs(np.diff(self.angle_rad, 2))
        scatter = 1.4826 * float(np.median(second)) / math.sqrt(6)
        return max(math.hypot(scatter, self.resolution_rad / math.sqrt(12)), math.radians(1e-3))


class Prior(NamedTuple):
    """Prior of a parameter: normal about a typical value, in its unit or in its logarithm."""

    typical: float
    sigma: float
    logarithmic: bool = False

    def value(self, x: Array) -> Array:
        """Return values in the parameter's unit, of x in standard deviations."""
        if self.logarithmic:
            return self.typical * np.exp(self.sigma * x)
        return self.typical + self.sigma * x


# What a test has beside the servo itself.
TEST_PRIORS = {
    "zero_rad": Prior(0.0, math.radians(10.0)),  # teeth of a horn are 14 to 17 degrees apart
    "delay_s": Prior(0.01, 0.05),  # half a frame of 20 ms, and a log that runs late
    "start_rad": Prior(0.0, math.radians(0.5)),  # mean of the rows before the first step
}
# A load that nobody stated pulls with parts of the stalled torque at two angles; of one that was
# stated, mass times distance and the angle at which it hangs down are uncertain.
UNSTATED_LOAD = {
    "load_over_torque_at_0_deg": Prior(0.0, 0.1),
    "load_over_torque_at_90_deg": Prior(0.0, 0.1),
}
STATED_LOAD = {
    "load_moment_ratio": Prior(1.0, 0.02, logarithmic=True),
    "load_down_rad": Prior(0.0, math.radians(5.0)),
}
# Parameters of a test that say nothing of the servo or the table.
UNREPORTED = {"start_rad", *STATED_LOAD}


def servo_priors(kind: ServoKind) -> dict[str, Prior]:
    """Return the priors of what a bench test can show of a servo.

    A joint without load shows no torque. What brakes it, motor and gear, it shows only together,
    and its speed and its rotor on a supply that sags under the whole duty.
    """
    servo, sigma = kind.servo, kind.sigma
    torque = servo.torque_limit_nm
    supply = 1 / (1 + servo.supply_sag)
    line = torque / servo.speed_limit_rad_s
    brake = supply * line + servo.gear_damping_nms_rad
    no_load = max(supply * torque - servo.gear_friction_nm, 0.0) / brake
    typical = {
        "stall_torque_nm": (servo.stall_torque_nm, "torque_limit_nm"),
        "no_load_rad_s": (no_load, "speed_limit_rad_s"),
        "stiffness_over_torque": (servo.stiffness_nm_rad / torque, "stiffness_nm_rad"),
        "rotor_over_brake_s": (servo.armature_kg_m2 / brake, "armature_kg_m2"),
        "gear_friction_over_torque": (servo.gear_friction_nm / torque, "gear_friction_nm"),
        "gear_damping_over_motors": (servo.gear_damping_nms_rad / line, "gear_damping_nms_rad"),
        "dead_band_rad": (servo.dead_band_rad, "dead_band_rad"),
        "supply_sag": (servo.supply_sag, "supply_sag"),
    }
    priors = {}
    for name, (value, field) in typical.items():
        # Torque and speed are those at a voltage that nobody may have measured.
        at_volts = field in ("torque_limit_nm", "speed_limit_rad_s")
        volts = sigma.get("supply_v", 0.0) if at_volts else 0.0
        priors[name] = Prior(value, math.hypot(sigma.get(field, 0.0), volts), logarithmic=True)
    derivative = (servo.damping_nms_rad - line) / max(servo.stiffness_nm_rad, 1e-12)
    # The loop's D beyond the motor's own has a sigma of 0.05 s, over its stiffness.
    return priors | {"derivative_s": Prior(derivative, 0.05)}


class BenchModel:
    """Angles that servos of a kind would have shown in a test, by their parameters.

    Parameters (K, P) are in standard deviations from their typical values; names has what each is.
    The last ones are delays of single steps. update_hz: the loop's rate; 0 for a continuous one.
    """

    def __init__(self, test: BenchTest, kind: ServoKind, update_hz: float) -> None:
        self.test, self.kind, self.update_hz = test, kind, update_hz
        self.period_s = 1 / update_hz if update_hz else 0.0
        self.priors = servo_priors(kind) | TEST_PRIORS
        # The joint's degrees for one of the setpoint have a sigma of 5 %.
        self.priors["gain"] = Prior(_sign_of_angles(test), 0.05, logarithmic=True)
        self.priors |= UNSTATED_LOAD if test.load is None else STATED_LOAD
        self.names = [name for name, prior in self.priors.items() if prior.sigma > 0]
        changes = np.flatnonzero(np.diff(test.setpoint_rad)) + 1
        sent_s = test.t_s if test.sent_s is None else test.sent_s
        self.setpoints_rad = test.setpoint_rad[np.r_[0, changes]]
        self.sent_s = np.r_[test.t_s[0], sent_s[changes]]
        self.start_rad = float(np.mean(test.angle_rad[: changes[0]][-5:]))
        self.steps = changes.size if changes.size <= MAX_STEPS else 0
        # A step waits for the loop's next sample, up to a period.
        # A step waits for a frame, 0 to 20 ms: a sigma of 6 ms.
        self.step_sigma_s = math.hypot(0.006, self.period_s / math.sqrt(12))
        self.size = len(self.names) + self.steps
        self.noise_rad = test.noise_rad

    def values(self, x: Array) -> Values:
        """Return each parameter in its own unit, (K,), of parameters (K, P)."""
        columns = dict.fromkeys(self.priors, np.zeros(len(x)))
        columns |= zip(self.names, x.T, strict=False)
        return {name: prior.value(columns[name]) for name, prior in self.priors.items()}

    def step_delays_s(self, x: Array) -> Array:
        """Return how much later than the others each step takes effect, (..., steps)."""
        return self.step_sigma_s * x[..., len(self.names) :]

    def fields(self, values: Values) -> Values:
        """Return the fields of servos with such values; the angles' own gain is left as it is.

        Speed and rotor are those of the whole duty on a supply that sags to a share h: what a joint
        shows of them does not depend on sag and gear. With f = q S and c = g S / w0 the speed is
        w0 (h - q) / (h + g), and the rotor's time J / (h S / w0 + c).
        """
        friction = np.minimum(values["gear_friction_over_torque"], 0.5)
        gear, sag = values["gear_damping_over_motors"], np.minimum(values["supply_sag"], 0.9)
        supply = 1 / (1 + sag)
        torque = values["stall_torque_nm"] / (1 - friction)
        speed = values["no_load_rad_s"] * (supply + gear) / (supply - friction)
        line, stiffness = torque / speed, values["stiffness_over_torque"] * torque
        return {
            "stiffness_nm_rad": stiffness,
            "damping_nms_rad": np.maximum(line + stiffness * values["derivative_s"], 0.0),
            "torque_limit_nm": torque,
            "speed_limit_rad_s": speed,
            "dead_band_rad": values["dead_band_rad"],
            "armature_kg_m2": values["rotor_over_brake_s"] * line * (supply + gear),
            "gear_friction_nm": friction * torque,
            "gear_damping_nms_rad": gear * line,
            "supply_sag": sag,
            "update_hz": np.full_like(sag, self.update_hz),
        }

    def angles(self, x: Array) -> Array:
        """Return the angles (K, T) that such servos would have shown, rad."""
        values, test, load = self.values(x), self.test, self.test.load
        gain, zero = values["gain"], values["zero_rad"]
        fields = self.fields(values)
        moment_nm, down_rad = np.zeros((2, len(x)))
        inertia = 0.0 if load is None else load.mass_kg * load.distance_m**2
        if load is None:
            at_0, at_90 = (values[name] for name in UNSTATED_LOAD)
            moment_nm = fields["torque_limit_nm"] * np.hypot(at_0, at_90)
            down_rad = -np.arctan2(at_0, at_90)
        elif load.level:
            weight = load.mass_kg * load.distance_m * GRAVITY_M_S2
            moment_nm = weight * values["load_moment_ratio"]
            down_rad = load.down_rad + values["load_down_rad"]
        fields |= {
            "gain": gain,
            "gravity_nm": moment_nm * np.sign(gain),  # sign of mirrored angles, too
            "gravity_angle_rad": zero - down_rad,
            "load_inertia_kg_m2": inertia,
            "start_rad": (self.start_rad + values["start_rad"] - zero) / gain,
        }
        effect_s = self.sent_s + values["delay_s"][:, None] + 0.5 * self.period_s
        if self.steps:
            effect_s[:, 1:] += self.step_delays_s(x)
        effect_s = np.ascontiguousarray(np.maximum.accumulate(effect_s, axis=1))
        joints = np.zeros((len(x), len(_core.BENCH_FIELDS)))
        for column, name in enumerate(_core.BENCH_FIELDS):
            joints[:, column] = fields.get(name, 0.0)
        angles = _core.bench_angles(joints, self.setpoints_rad, effect_s, test.t_s)
        return gain[:, None] * angles + zero[:, None]

    def residuals(self, x: Array) -> Array:
        """Return (K, T) what the model has above the table, over the noise."""
        return (self.angles(x) - self.test.angle_rad) / self.noise_rad

    def samples(self, x: Array, rng: np.random.Generator) -> Values:
        """Return what such parameters say of servo and table, by name, (K,).

        Where setpoints and angles differ by a gain, a table does not tell which of the two is
        wrong. So half of the servos have the angles' speed, half the setpoints'. The wait for the
        loop's next sample is no delay of the log. The table does not tell it either; it is the same
        for all steps where these are sent at multiples of the loop's period.
        """
        values = self.values(x)
        gain = np.where(rng.random(len(x)).round() < 1, np.abs(values["gain"]), 1.0)
        values["no_load_rad_s"] *= gain
        values["dead_band_rad"] *= gain
        values["stiffness_over_torque"] /= gain
        values["delay_s"] += self.period_s * rng.uniform(-0.5, 0.5, len(x))
        if self.steps:
            values["delay_s"] += self.step_delays_s(x).mean(axis=1)
        return values

    def servos(self, values: Values, rng: np.random.Generator) -> list[Servo]:
        """Return servos with such values; the voltage is drawn from the kind."""
        typical, fields = self.kind.servo, self.fields(values)
        half_width = math.sqrt(3) * self.kind.sigma.get("supply_v", 0.0)
        count = values["no_load_rad_s"].size
        fields["supply_v"] = typical.supply_v * np.exp(rng.uniform(-half_width, half_width, count))
        rows = np.column_stack(list(fields.values())).tolist()
        return [
            Servo(**dict(zip(fields, row, strict=True)), frame_s=typical.frame_s) for row in rows
        ]


def _sign_of_angles(test: BenchTest) -> float:
    """Return 1, or -1 where the angle turns the other way. Raises BadInput for another unit."""
    moved, slope = test.angle_rad - test.angle_rad.mean(), 0.0
    for late_s in np.arange(0.0, 0.31, 0.02):
        sent = np.interp(test.t_s - late_s, test.t_s, test.setpoint_rad)
        sent -= sent.mean()
        slope = max(slope, float(sent @ moved / max(sent @ sent, 1e-12)), key=abs)
    if not MIN_GAIN < abs(slope) < MAX_GAIN:
        raise BadInput(
            f"the angle moves by {slope:.2g} degrees for a degree of the setpoint; both must be "
            "the joint's, in degrees (57 or 0.017: one of them is in radians)"
        )
    return math.copysign(1.0, slope)
