"""A bench test of one joint: the table, and a servo's parameters under which a joint moves so.

A parameter is counted in standard deviations of its prior, so that all are standard normal before
the test. Torques are relative to the motor's stalled torque unless the joint turns a known load.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base.checks import check_number
from ..base.errors import BadInput
from ..base.vectors import finite_vector
from ..model.drives import Servo, ServoKind

Array = NDArray[np.float64]
Values = dict[str, Array]
GRAVITY_M_S2 = 9.81
MIN_ROWS, MAX_TEST_S = 10, 20.0
MAX_STEPS = 40  # with a delay of their own; a gait's setpoints share one delay
DIFFERENCE_STEP = 1e-3  # standard deviations of the priors, for derivatives
MIN_STEP_S = 0.05  # between such steps, longer than two frames of a board


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
        check_number("mass_kg", self.mass_kg, 0.0, open_low=True)
        check_number("distance_m", self.distance_m, 0.0, open_low=True)
        check_number("down_rad", self.down_rad)


@dataclass(frozen=True)
class BenchTest:
    """What was sent to one joint, and the angles that were seen.

    t_s (T,), rising; setpoint_rad (T,), each held until the next time; angle_rad (T,), with the
    standard deviation sigma_rad; None: the table's own scatter. inertia_kg_m2: of what the servo
    turns, beside the load. sent_s (T,): when the row's setpoint was sent, by the host's clock; None
    for the row's time. Raises BadInput.
    """

    t_s: Array
    setpoint_rad: Array
    angle_rad: Array
    sigma_rad: float | None = None
    inertia_kg_m2: float = 0.0
    load: Load | None = None
    sent_s: Array | None = None

    def __post_init__(self) -> None:
        names = ["t_s", "setpoint_rad", "angle_rad"]
        names += ["sent_s"] if self.sent_s is not None else []
        for name in names:
            given: ArrayLike = getattr(self, name)
            count = np.size(given)
            object.__setattr__(self, name, np.array(finite_vector(name, given, count), dtype=float))
        if len({getattr(self, name).size for name in names}) != 1:
            raise BadInput(f"{', '.join(names)} must have one value each row")
        if self.t_s.size < MIN_ROWS or not (np.diff(self.t_s) > 0).all():
            raise BadInput(
                f"a bench test needs {MIN_ROWS} rows or more at rising times; got {self.t_s.size}"
            )
        if np.ptp(self.t_s) > MAX_TEST_S:
            raise BadInput(
                f"the test lasts {np.ptp(self.t_s):.3g} s; give {MAX_TEST_S:.0f} s at most"
            )
        if np.ptp(self.setpoint_rad) == 0:
            raise BadInput("the setpoint never changes; send a step, or a gait")
        if self.sigma_rad is not None:
            check_number("sigma_rad", self.sigma_rad, 0.0, 1.0, open_low=True)
        check_number("inertia_kg_m2", self.inertia_kg_m2, 0.0)

    @property
    def noise_rad(self) -> float:
        """Return the standard deviation of an angle: as stated, or by its second differences.

        The resolution of the table is in it. The median leaves the rows out in which the joint
        comes to speed or stops.
        """
        if self.sigma_rad is not None:
            return self.sigma_rad
        second = np.abs(np.diff(self.angle_rad, 2))
        steps = np.diff(np.unique(np.round(self.angle_rad, 9)))
        resolution = float(steps.min()) if steps.size else 0.0
        scatter = 1.4826 * float(np.median(second)) / math.sqrt(6)
        return max(math.hypot(scatter, resolution / math.sqrt(12)), math.radians(1e-3))


@dataclass(frozen=True)
class BenchPrior:
    """Standard deviations of what a test has beside the servo itself."""

    zero_rad: float = math.radians(10.0)  # teeth of a horn are 14 to 17 degrees apart
    log_gain: float = 0.05  # degrees of the joint for a degree of the setpoint
    typical_delay_s: float = 0.01  # half a frame of 20 ms
    delay_s: float = 0.05  # of the log, or before the board hears the host
    step_delay_s: float = 0.006  # of each step: it waits for a frame, 0 to 20 ms
    derivative_s: float = 0.05  # D of the loop beyond the motor's own, over its stiffness
    gravity: float = 0.1  # of the stalled torque: of a load that nobody stated
    down_rad: float = math.radians(5.0)  # of the angle at which a stated load hangs down
    log_moment: float = 0.02  # of a stated load: mass and distance
    start_rad: float = math.radians(0.5)  # from the angle of the rows before the first step


def shown(servo: Servo) -> dict[str, float]:
    """Return what a bench test can show of a servo, most of it relative to the motor's torque.

    A joint without load shows no torque. What brakes it, motor and gear, it shows only together,
    and its speed and its rotor on a supply that sags under the whole duty.
    """
    torque, sag = servo.torque_limit_nm, 1 / (1 + servo.supply_sag)
    line = torque / servo.speed_limit_rad_s
    friction = servo.gear_friction_nm
    return {
        "no_load_rad_s": max(sag * torque - friction, 0.0)
        / (sag * line + servo.gear_damping_nms_rad),
        "stall_torque_nm": servo.stall_torque_nm,
        "stiffness_over_torque": servo.stiffness_nm_rad / torque,
        "derivative_s": (servo.damping_nms_rad - line) / max(servo.stiffness_nm_rad, 1e-12),
        "rotor_over_brake_s": servo.armature_kg_m2 / (sag * line + servo.gear_damping_nms_rad),
        "gear_friction_over_torque": friction / torque,
        "gear_damping_over_motors": servo.gear_damping_nms_rad / line,
        "dead_band_rad": servo.dead_band_rad,
        "supply_sag": servo.supply_sag,
        "supply_v": servo.supply_v,
    }


# Of a servo: the parameter, the name of its sigma in a ServoKind, and of its typical value above.
_OF_SERVO = (
    ("torque", "torque_limit_nm", "stall_torque_nm"),
    ("speed", "speed_limit_rad_s", "no_load_rad_s"),
    ("stiffness", "stiffness_nm_rad", "stiffness_over_torque"),
    ("rotor", "armature_kg_m2", "rotor_over_brake_s"),
    ("friction", "gear_friction_nm", "gear_friction_over_torque"),
    ("damping", "gear_damping_nms_rad", "gear_damping_over_motors"),
    ("dead_band", "dead_band_rad", "dead_band_rad"),
    ("sag", "supply_sag", "supply_sag"),
)
# What the values of parameters are called in answers; a step's delay is called as it is.
NAMES = {name: value for name, _, value in _OF_SERVO} | {
    "derivative": "derivative_s",
    "zero": "zero_rad",
    "delay": "delay_s",
    "gravity_0": "load_over_torque_at_0_deg",
    "gravity_90": "load_over_torque_at_90_deg",
}


@dataclass(frozen=True)
class BenchModel:
    """Angles that servos of a kind would have shown in a test, by their parameters.

    Parameters (K, P) are in standard deviations from their typical values. update_hz: how often the
    loop looks. blend: a look has the mean setpoint since the look before, so that the angles change
    smoothly with delays; for a search.
    """

    test: BenchTest
    kind: ServoKind
    update_hz: float
    blend: bool = False
    prior: BenchPrior = field(default_factory=BenchPrior)

    def __post_init__(self) -> None:
        test, prior = self.test, self.prior
        typical = shown(self.kind.servo)
        sigma: Mapping[str, float] = self.kind.sigma
        plug = sigma.get("supply_v", 0.0)
        spreads = {}
        for name, of, value in _OF_SERVO:
            spread = sigma.get(of, 0.0)
            if name in ("torque", "speed"):  # at the test's voltage, which nobody may have measured
                spread = math.hypot(spread, plug)
            spreads[name] = (typical[value], spread)
        changes = np.flatnonzero(np.diff(test.setpoint_rad)) + 1
        sent = test.t_s if test.sent_s is None else test.sent_s
        sizes = {"derivative": prior.derivative_s, "zero": prior.zero_rad, "gain": prior.log_gain}
        sizes |= {"delay": prior.delay_s, "start": prior.start_rad}
        if self.update_hz:
            sizes["look"] = 1.0
        if test.load is None:
            sizes |= {"gravity_0": prior.gravity, "gravity_90": prior.gravity}
        else:
            sizes |= {"moment": prior.log_moment, "down": prior.down_rad}
        names = [name for name, (_, spread) in spreads.items() if spread > 0] + list(sizes)
        few = changes.size <= MAX_STEPS
        if few and (changes.size < 2 or np.median(np.diff(sent[changes])) > MIN_STEP_S):
            names += [f"step {k}" for k in range(changes.size)]
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "_spreads", spreads)
        object.__setattr__(self, "_sizes", sizes)
        object.__setattr__(self, "_setpoints", test.setpoint_rad[np.r_[0, changes]])
        object.__setattr__(self, "_sent", np.r_[test.t_s[0], sent[changes]])
        object.__setattr__(self, "_start", float(np.mean(test.angle_rad[: changes[0]][-5:])))
        object.__setattr__(self, "_sign", _sign_of_angles(test))

    names: list[str] = field(init=False)
    _spreads: dict[str, tuple[float, float]] = field(init=False)
    _sizes: dict[str, float] = field(init=False)
    _setpoints: Array = field(init=False)
    _sent: Array = field(init=False)
    _start: float = field(init=False)
    _sign: float = field(init=False)

    def values(self, x: Array) -> Values:
        """Return each parameter in its own unit, (K,), of parameters (K, P)."""
        column = dict(zip(self.names, x.T, strict=True))
        none = np.zeros(len(x))
        values = {
            name: typical * np.exp(spread * column.get(name, none))
            for name, (typical, spread) in self._spreads.items()
        }
        for name, size in self._sizes.items():
            values[name] = size * column[name]
        values["derivative"] = values["derivative"] + shown(self.kind.servo)["derivative_s"]
        values["gain"] = self._sign * np.exp(values["gain"])
        values["delay"] = values["delay"] + self.prior.typical_delay_s
        values["step delays"] = self.prior.step_delay_s * x[:, self.step_columns]
        return values

    @property
    def difference_steps(self) -> Array:
        """Return the steps (P,) of derivatives, in standard deviations of the priors.

        A loop that looks now and then hears a setpoint at its next look. So a delay moves the joint
        by jumps, and its derivative is taken over a whole interval between two looks.
        """
        steps = np.full(len(self.names), DIFFERENCE_STEP)
        if self.update_hz and not self.blend:
            look_s, delay = 1 / self.update_hz, self.names.index("delay")
            steps[delay] = min(look_s / self.prior.delay_s, 1.0)
            steps[self.step_columns] = min(look_s / self.prior.step_delay_s, 1.0)
        return steps

    @property
    def step_columns(self) -> list[int]:
        """Return the columns of the steps' own delays."""
        return [k for k, name in enumerate(self.names) if name.startswith("step ")]

    def fields(self, values: Values) -> Values:
        """Return the fields of servos with such values; the angles' own gain is left as it is.

        Speed and rotor are those of the whole duty on a supply that sags to a share h: what a joint
        shows of them does not hang on sag and gear. With f = q S and c = g S / w0 the speed is
        w0 (h - q) / (h + g), and the rotor's time J / (h S / w0 + c).
        """
        friction, gear = np.minimum(values["friction"], 0.5), values["damping"]
        sag = np.minimum(values["sag"], 0.9)
        share = 1 / (1 + sag)
        torque = values["torque"] / (1 - friction)
        speed = values["speed"] * (share + gear) / (share - friction)
        line, stiffness = torque / speed, values["stiffness"] * torque
        return {
            "stiffness_nm_rad": stiffness,
            "damping_nms_rad": np.maximum(line + stiffness * values["derivative"], 0.0),
            "torque_limit_nm": torque,
            "speed_limit_rad_s": speed,
            "dead_band_rad": values["dead_band"],
            "armature_kg_m2": values["rotor"] * line * (share + gear),
            "gear_friction_nm": friction * torque,
            "gear_damping_nms_rad": gear * line,
            "supply_sag": sag,
        }

    def angles(self, x: Array) -> Array:
        """Return the angles (K, T) that such servos would have shown, rad."""
        from scipy.special import ndtr

        values, test = self.values(x), self.test
        fields = self.fields(values)
        gain, zero = values["gain"], values["zero"]
        fields["update_hz"] = np.full(len(x), self.update_hz)
        if self.update_hz:
            fields["first_look_s"] = ndtr(values["look"]) / self.update_hz
            fields["blend"] = np.full(len(x), float(self.blend))
        inertia, load = test.inertia_kg_m2, test.load
        fields["gain"] = gain
        if load is None:
            torque = fields["torque_limit_nm"]
            fields["gravity_nm"] = torque * np.hypot(values["gravity_0"], values["gravity_90"])
            fields["gravity_angle_rad"] = np.arctan2(values["gravity_0"], values["gravity_90"])
            fields["gravity_angle_rad"] += zero
        else:
            inertia += load.mass_kg * load.distance_m**2
            if load.level:
                moment = load.mass_kg * load.distance_m * np.exp(values["moment"])
                fields["gravity_nm"] = moment * GRAVITY_M_S2
                fields["gravity_angle_rad"] = zero - load.down_rad - values["down"]
        if "gravity_nm" in fields:  # of a joint whose angles are mirrored, too
            fields["gravity_nm"] = fields["gravity_nm"] * np.sign(gain)
        fields["load_inertia_kg_m2"] = np.full(len(x), inertia)
        fields["start_rad"] = (self._start + values["start"] - zero) / gain
        heard = self._sent + values["delay"][:, None]
        if values["step delays"].size:
            heard[:, 1:] += values["step delays"]
        none = np.zeros(len(x))
        joints = np.column_stack([fields.get(name, none) for name in _core.BENCH_FIELDS])
        heard = np.ascontiguousarray(np.maximum.accumulate(heard, axis=1))
        seen = _core.bench_angles(np.ascontiguousarray(joints), self._setpoints, heard, test.t_s)
        return gain[:, None] * seen + zero[:, None]

    def servos(self, x: Array, rng: np.random.Generator) -> list[Servo]:
        """Return servos with such parameters; what is not in the test is drawn from the kind.

        Where setpoints and angles differ by a gain, a table does not tell which of the two is
        wrong. So half of the servos have the angles' speed, half the setpoints'.
        """
        values = self.values(x)
        gain = np.where(rng.random(len(x)) < 0.5, np.abs(values["gain"]), 1.0)
        values["speed"] = values["speed"] * gain
        values["dead_band"] = values["dead_band"] * gain
        values["stiffness"] = values["stiffness"] / gain
        fields = self.fields(values)
        typical = self.kind.servo
        even = math.sqrt(3) * self.kind.sigma.get("supply_v", 0.0)
        fields["supply_v"] = typical.supply_v * np.exp(rng.uniform(-even, even, len(x)))
        rows = np.column_stack(list(fields.values())).tolist()
        own = {"frame_s": typical.frame_s, "update_hz": self.update_hz}
        return [Servo(**dict(zip(fields, row, strict=True)), **own) for row in rows]

    def beside(self, x: Array) -> Values:
        """Return what such parameters say of the test itself: zero, gain, delay, a load."""
        values = self.values(x)
        steps = values["step delays"]
        values["delay"] = values["delay"] + (steps.mean(axis=1) if steps.size else 0.0)
        names = ["zero", "gain", "delay"]
        names += ["gravity_0", "gravity_90"] if self.test.load is None else []
        return {NAMES.get(name, name): values[name] for name in names}


def _sign_of_angles(test: BenchTest) -> float:
    """Return 1, or -1 where the angle turns the other way. Raises BadInput for another unit."""
    slopes = []
    for late_s in np.arange(0.0, 0.31, 0.02):
        index = np.searchsorted(test.t_s, test.t_s - late_s, side="right") - 1
        sent = test.setpoint_rad[np.maximum(index, 0)]
        sent, seen = sent - sent.mean(), test.angle_rad - test.angle_rad.mean()
        slopes.append(float(sent @ seen / max(sent @ sent, 1e-12)))
    slope = max(slopes, key=abs)
    if not 0.1 < abs(slope) < 1.7:
        raise BadInput(
            f"the angle moves by {slope:.2g} degrees for a degree of the setpoint; both must be "
            "the joint's, in degrees"
        )
    return math.copysign(1.0, slope)
