"""A bench test of one joint: its table, and the angles that a servo's parameters predict for it.

Parameters are in standard deviations of their priors from the typical value, so that each prior is
standard normal. Torques are relative to the motor's stall torque unless the joint turns a known
load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .. import _core
from ..base.checks import check_number, check_whole
from ..base.errors import BadInput
from ..base.vectors import Array
from ..model.drives import Servo, ServoKind

Values = dict[str, Array]


@dataclass(frozen=True)
class Load:
    """A mass at a distance from the joint's axis.

    level: whether the axis is level, so that gravity acts on the joint; if not, the load is only an
    inertia. down_rad: angle of the joint at which the mass hangs straight down. Raises BadInput.
    """

    mass_kg: float
    distance_m: float
    level: bool = True
    down_rad: float = 0.0

    def __post_init__(self) -> None:
        # 5 kg at 1 m pull with ten times the torque of a large hobby servo.
        check_number("mass_kg", self.mass_kg, 0.0, 5.0, open_low=True)
        check_number("distance_m", self.distance_m, 0.0, 1.0, open_low=True)


@dataclass(frozen=True)
class BenchTest:
    """The table of a test: the setpoints sent to one joint, and the measured angles.

    t_s: (T,), increasing. setpoint_rad: (T,), each valid until the next time. angle_rad: (T,).
    sigma_rad: standard deviation of an angle; None: it is estimated from the table. load: what the
    joint turns; None if it is unknown. sent_s: (T,), time at which each row's setpoint was sent;
    None: at the row's time. Raises BadInput.
    """

    t_s: Array
    setpoint_rad: Array
    angle_rad: Array
    sigma_rad: float | None = None
    load: Load | None = None
    sent_s: Array | None = None

    def __post_init__(self) -> None:
        check_whole("number of rows", self.t_s.size, 10)
        if not (np.diff(self.t_s) > 0).all():
            raise BadInput("t_s must rise from row to row")
        check_number("duration of the test in s", float(np.ptp(self.t_s)), 0.0, 20.0)
        # Dead band and play of gears take about as much.
        span_deg = math.degrees(np.ptp(self.setpoint_rad))
        check_number("span of the setpoints in degrees, not radians,", span_deg, 4.0)

    @property
    def resolution_rad(self) -> float:
        """Return the smallest difference between two angles of the table, rad."""
        angles_rad = np.unique(np.round(self.angle_rad, 9))
        steps = np.diff(angles_rad)
        return float(steps.min()) if steps.size else 0.0

    @property
    def noise_rad(self) -> float:
        """Return the standard deviation of an angle, rad: as stated, or from second differences.

        The estimate includes the table's resolution. It takes the median, so that the rows in which
        the joint accelerates hardly count.
        """
        if self.sigma_rad is not None:
            return self.sigma_rad
        second = np.abs(np.diff(self.angle_rad, 2))
        scatter = 1.4826 * float(np.median(second)) / math.sqrt(6)  # Normal errors: sigma / MAD.
        return max(math.hypot(scatter, self.resolution_rad / math.sqrt(12)), math.radians(1e-3))


class Prior(NamedTuple):
    """Normal prior of a parameter about a typical value, or normal prior of its logarithm.

    reported: whether the parameter describes the servo or the table.
    """

    typical: float
    sigma: float
    logarithmic: bool = False
    reported: bool = True

    def value(self, x: Array) -> Array:
        """Return values (K,) in the parameter's unit, given x (K,) in standard deviations."""
        if self.logarithmic:
            return self.typical * np.exp(self.sigma * x)
        return self.typical + self.sigma * x


# An unstated load has two unknown torques, over the stall torque, with the joint at 0 and at 90
# degrees. A stated load is uncertain by its mass times distance and the angle of hanging down.
UNSTATED_LOAD = {
    "load_over_torque_at_0_deg": Prior(0.0, 0.1),
    "load_over_torque_at_90_deg": Prior(0.0, 0.1),
}
STATED_LOAD = {
    "load_moment_ratio": Prior(1.0, 0.02, logarithmic=True, reported=False),
    "load_down_rad": Prior(0.0, math.radians(5.0), reported=False),
}


def servo_priors(kind: ServoKind) -> dict[str, Prior]:
    """Return the priors of the parameters that a bench test can determine, name -> prior.

    Without a load a test shows no torque, so that stiffness, friction and damping are ratios to the
    motor's. Motor and gear damping act together, and so the no-load speed and the rotor's time
    constant contain both, on a supply that sags at full duty.
    """
    servo, sigma = kind.servo, kind.sigma
    torque = servo.torque_limit_nm
    supply = 1 / (1 + servo.supply_sag)
    motor_damping = torque / servo.speed_limit_rad_s
    damping = supply * motor_damping + servo.gear_damping_nms_rad
    no_load = max(supply * torque - servo.gear_friction_nm, 0.0) / damping
    typical = {
        "stall_torque_nm": (servo.stall_torque_nm, "torque_limit_nm"),
        "no_load_rad_s": (no_load, "speed_limit_rad_s"),
        "stiffness_over_torque": (servo.stiffness_nm_rad / torque, "stiffness_nm_rad"),
        "rotor_over_brake_s": (servo.armature_kg_m2 / damping, "armature_kg_m2"),
        "gear_friction_over_torque": (servo.gear_friction_nm / torque, "gear_friction_nm"),
        "gear_damping_over_motors": (
            servo.gear_damping_nms_rad / motor_damping,
            "gear_damping_nms_rad",
        ),
        "dead_band_rad": (servo.dead_band_rad, "dead_band_rad"),
        "supply_sag": (servo.supply_sag, "supply_sag"),
    }
    priors = {}
    for name, (value, field) in typical.items():
        # Torque and speed scale with the supply's voltage, which is uncertain too.
        at_volts = field in ("torque_limit_nm", "speed_limit_rad_s")
        volts = at_volts * sigma.get("supply_v", 0.0)
        priors[name] = Prior(value, math.hypot(sigma.get(field, 0.0), volts), logarithmic=True)
    # Derivative gain of the loop over its proportional gain, with a sigma of 0.05 s.
    derivative = (servo.damping_nms_rad - motor_damping) / max(servo.stiffness_nm_rad, 1e-12)
    return priors | {"derivative_s": Prior(derivative, 0.05)}


class BenchModel:
    """The model of a test: angles as a function of the parameters of a servo of some kind.

    Parameters x are (K, P), in standard deviations from their typical values. The first ones are
    those in names; the last ones are the delays of single steps. update_hz: rate of the servo's
    control loop; 0 for a continuous loop. max_steps: most steps with separate delays; the many
    setpoints of a gait share one delay.
    """

    def __init__(
        self, test: BenchTest, kind: ServoKind, update_hz: float, max_steps: int = 40
    ) -> None:
        self.test, self.kind, self.update_hz = test, kind, update_hz
        self.period_s = 1 / update_hz if update_hz else 0.0
        self.priors = servo_priors(kind) | {
            # The teeth of a horn are 14 to 17 degrees apart.
            "zero_rad": Prior(0.0, math.radians(10.0)),
            # Half a frame of 20 ms, plus the delay of the log.
            "delay_s": Prior(0.01, 0.05),
            # Correction to the mean before the first step.
            "start_rad": Prior(0.0, math.radians(0.5), reported=False),
            # The gain is the ratio of a change of the angle to that of the setpoint.
            "gain": Prior(_gain_sign(test), 0.05, logarithmic=True),
        }
        self.priors |= UNSTATED_LOAD if test.load is None else STATED_LOAD
        self.names = [name for name, prior in self.priors.items() if prior.sigma > 0]
        changes = np.flatnonzero(np.diff(test.setpoint_rad)) + 1
        sent_s = test.t_s if test.sent_s is None else test.sent_s
        self.setpoints_rad = test.setpoint_rad[np.r_[0, changes]]
        self.sent_s = np.r_[test.t_s[0], sent_s[changes]]
        first = changes[0]
        self.start_rad = float(np.mean(test.angle_rad[:first][-5:]))
        self.steps = changes.size if changes.size <= max_steps else 0
        # A step waits for the next frame of 20 ms and for the loop's next sample, both uniform.
        self.step_sigma_s = math.hypot(0.006, self.period_s / math.sqrt(12))
        self.size = len(self.names) + self.steps
        self.noise_rad = test.noise_rad

    def values(self, x: Array) -> Values:
        """Return parameters x (K, P) in their units, name -> (K,)."""
        columns = dict.fromkeys(self.priors, np.zeros(len(x)))
        columns |= zip(self.names, x.T, strict=False)
        return {name: prior.value(columns[name]) for name, prior in self.priors.items()}

    def step_delays_s(self, x: Array) -> Array:
        """Return the delay of each step beyond the common one, s, (..., steps)."""
        return self.step_sigma_s * x[..., len(self.names) :]

    def fields(self, values: Values) -> Values:
        """Return the fields of Servo for parameter values, name -> (K,).

        A motor has the stall torque S and the no-load speed w0, and its gear the friction q S and
        the damping g S / w0. If the supply sags to the share h at full duty, the joint's no-load
        speed is w0 (h - q) / (h + g), and the rotor's time constant J w0 / (S (h + g)). These two
        are parameters; w0 and J follow from them.
        """
        friction = np.minimum(values["gear_friction_over_torque"], 0.5)
        gear, sag = values["gear_damping_over_motors"], np.minimum(values["supply_sag"], 0.9)
        supply = 1 / (1 + sag)
        torque = values["stall_torque_nm"] / (1 - friction)
        speed = values["no_load_rad_s"] * (supply + gear) / (supply - friction)
        motor_damping = torque / speed
        stiffness = values["stiffness_over_torque"] * torque
        return {
            "stiffness_nm_rad": stiffness,
            "damping_nms_rad": np.maximum(motor_damping + stiffness * values["derivative_s"], 0.0),
            "torque_limit_nm": torque,
            "speed_limit_rad_s": speed,
            "dead_band_rad": values["dead_band_rad"],
            "armature_kg_m2": values["rotor_over_brake_s"] * motor_damping * (supply + gear),
            "gear_friction_nm": friction * torque,
            "gear_damping_nms_rad": gear * motor_damping,
            "supply_sag": sag,
            "update_hz": np.full_like(sag, self.update_hz),
        }

    def angles(self, x: Array) -> Array:
        """Return the predicted angles (K, T), rad."""
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
            weight = load.mass_kg * load.distance_m * 9.81
            moment_nm = weight * values["load_moment_ratio"]
            down_rad = load.down_rad + values["load_down_rad"]
        fields |= {
            "gain": gain,
            "gravity_nm": moment_nm * np.sign(gain),  # Mirrored angles mirror gravity too.
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
        """Return predicted less measured angles over their standard deviation, (K, T)."""
        return (self.angles(x) - self.test.angle_rad) / self.noise_rad

    def samples(self, x: Array, rng: np.random.Generator) -> Values:
        """Return samples of the parameters of servo and table in their units, name -> (K,).

        If angles and setpoints differ by a gain, a table cannot show which of the two is wrong. So
        half of the samples trust the angles, and half the setpoints. The common delay contains the
        wait for the loop's next sample, up to a period, which a table cannot show either.
        """
        values = self.values(x)
        trusts_angles = rng.random(len(x)).round() < 1
        gain = np.where(trusts_angles, np.abs(values["gain"]), 1.0)
        values["no_load_rad_s"] *= gain
        values["dead_band_rad"] *= gain
        values["stiffness_over_torque"] /= gain
        values["delay_s"] += self.period_s * rng.uniform(-0.5, 0.5, len(x))
        if self.steps:
            values["delay_s"] += self.step_delays_s(x).mean(axis=1)
        return values

    def servos(self, values: Values, rng: np.random.Generator) -> list[Servo]:
        """Return a servo for each sample of values (K,); the kind's supply voltage is sampled."""
        typical, fields = self.kind.servo, self.fields(values)
        half_width = math.sqrt(3) * self.kind.sigma.get("supply_v", 0.0)
        count = values["no_load_rad_s"].size
        fields["supply_v"] = typical.supply_v * np.exp(rng.uniform(-half_width, half_width, count))
        rows = np.column_stack(list(fields.values())).tolist()
        return [
            Servo(**dict(zip(fields, row, strict=True)), frame_s=typical.frame_s) for row in rows
        ]


def _gain_sign(test: BenchTest, min_gain: float = 0.1, max_gain: float = 1.7) -> float:
    """Return 1, or -1 if angles decrease with setpoints; raises BadInput if their units differ.

    The gain is the largest regression slope of angles over setpoints delayed by 0 to 0.3 s.
    min_gain, max_gain: limits outside which a unit was mistaken.
    """
    angle, gain = test.angle_rad - test.angle_rad.mean(), 0.0
    for delay_s in np.arange(0.0, 0.31, 0.02):
        setpoint = np.interp(test.t_s - delay_s, test.t_s, test.setpoint_rad)
        setpoint -= setpoint.mean()
        slope = setpoint @ angle / max(setpoint @ setpoint, 1e-12)
        gain = max(gain, float(slope), key=abs)
    if not min_gain < abs(gain) < max_gain:
        raise BadInput(
            f"the angle moves by {gain:.2g} degrees for a degree of the setpoint; both must be "
            "the joint's, in degrees (57 or 0.017: one of them is in radians)"
        )
    return math.copysign(1.0, gain)
