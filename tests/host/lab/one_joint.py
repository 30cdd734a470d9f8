"""A servo on a bench, of which no fit knows: motor with its wires, gear, friction, load, and a log.

The motor has a torque constant, a resistance and a supply with a resistance of its own, and it is
stepped in 10 microseconds. Friction takes speed away step by step, and no more than there is. A fit
has the same law of a servo in other terms: stalled torque, line, and exact pieces between stops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import serpenoid as sn
from serpenoid.servos.bench_test import BenchTest, Load

ROWS_HZ = 240.0
EVERY = 416  # steps from row to row
STEP_S = 1 / ROWS_HZ / EVERY
VOLT = 6.0
NOISE_RAD, STATED_RAD = math.radians(0.3), math.radians(0.4)
# A test of 2.4 s: when each setpoint is sent, s, and where to, deg.
SENT = ((0.0, 0.0), (0.13, 45.0), (0.5, -40.0), (1.0, -35.0), (1.2, -33.0), (1.42, -20.0))
SENT += ((1.72, 30.0), (2.11, 25.0))
DURATION_S = 2.4
SENT_S = np.array([t for t, _ in SENT[1:]])
ROW_S = np.ceil(SENT_S * ROWS_HZ - 1e-9) / ROWS_HZ  # the first row that has the setpoint


@dataclass(frozen=True)
class Hidden:
    """A servo that is to be found, and what its log has: zero, gain, delays, a load.

    servo: its law; the rates of its loop are in it. delays_s: of each setpoint, and of none of the
    log's. load: what hangs on it, and moment_nm what pulls without anybody saying so.
    """

    servo: sn.Servo
    zero_rad: float = 0.0
    gain: float = 1.0
    delays_s: tuple[float, ...] = (0.0,) * (len(SENT) - 1)
    load: Load | None = None
    moment_nm: float = 0.0
    look_s: float = 0.0

    @property
    def truth(self) -> dict[str, float]:
        """Return the values that a fit may state, by its names."""
        s = self.servo
        line, sag = s.torque_limit_nm / s.speed_limit_rad_s, 1 + s.supply_sag
        # a run in time without load: what the motor gives at the whole duty is what the gear takes
        free = (s.torque_limit_nm / sag - s.gear_friction_nm) / (
            line / sag + s.gear_damping_nms_rad
        )
        values = {
            "no_load_rad_s": free,
            "stall_torque_nm": s.torque_limit_nm - s.gear_friction_nm,
            "stiffness_over_torque": s.stiffness_nm_rad / s.torque_limit_nm,
            "derivative_s": (s.damping_nms_rad - line) / s.stiffness_nm_rad,
            "rotor_over_brake_s": s.armature_kg_m2 / (line / sag + s.gear_damping_nms_rad),
            "gear_friction_over_torque": s.gear_friction_nm / s.torque_limit_nm,
            "gear_damping_over_motors": s.gear_damping_nms_rad / line,
            "dead_band_rad": s.dead_band_rad,
            "supply_sag": s.supply_sag,
            "zero_rad": self.zero_rad,
            "gain": self.gain,
            "delay_s": float(np.mean(self.delays_s) + np.mean(SENT_S - ROW_S)),
        }
        if self.load is None:
            values["load_over_torque_at_0_deg"] = 0.0
            values["load_over_torque_at_90_deg"] = self.moment_nm / s.torque_limit_nm
        return values


def _column(name: str, hidden: list[Hidden]) -> np.ndarray:
    return np.array([getattr(one.servo, name) for one in hidden])


def moved(hidden: list[Hidden]) -> tuple[np.ndarray, np.ndarray]:
    """Return times (T,) of the rows, and the angles (K, T) of the servos' own sensors, rad."""
    torque, speed = _column("torque_limit_nm", hidden), _column("speed_limit_rad_s", hidden)
    constant = VOLT / speed  # V s, and N m/A: the same number
    ohm = constant * VOLT / torque
    wires = ohm * _column("supply_sag", hidden)
    spring, damper = _column("stiffness_nm_rad", hidden), _column("damping_nms_rad", hidden)
    band, dry = _column("dead_band_rad", hidden), _column("gear_friction_nm", hidden)
    viscous = _column("gear_damping_nms_rad", hidden)
    zero, gain = np.array([[h.zero_rad, h.gain] for h in hidden]).T
    loads = [h.load for h in hidden]
    inertia = _column("armature_kg_m2", hidden)
    inertia = inertia + [0.0 if w is None else w.mass_kg * w.distance_m**2 for w in loads]
    pulls = np.array([0.0 if w is None else w.mass_kg * w.distance_m for w in loads])
    pulls = 9.81 * pulls + [h.moment_nm for h in hidden]
    hz = _column("update_hz", hidden)
    period = np.where(hz > 0, 1 / np.maximum(hz, 1.0), STEP_S)
    next_look = np.array([h.look_s for h in hidden])
    heard = np.array([[0.0, *(SENT_S + h.delays_s)] for h in hidden])
    goals = np.radians([goal for _, goal in SENT])

    count = round(DURATION_S / STEP_S)
    angle, rate, duty = (np.zeros(len(hidden)) for _ in range(3))
    goal = np.full(len(hidden), goals[0])
    changes = sorted({round(t / STEP_S) for t in heard[:, 1:].ravel()})
    changing, seen = set(changes), []
    for k in range(count):
        t = k * STEP_S
        if k in changing:
            goal = goals[np.sum(heard <= t + 0.5 * STEP_S, axis=1) - 1]
        if k % EVERY == 0:
            seen.append(angle)
        error = goal - angle
        error = np.sign(error) * np.maximum(np.abs(error) - band, 0.0)
        volts = VOLT * (spring * error - damper * rate) / torque + constant * rate
        looks = t >= next_look - 1e-9
        duty = np.where(looks, np.clip(volts / VOLT, -1.0, 1.0), duty)
        next_look = np.where(looks, next_look + period, next_look)
        ampere = (VOLT * duty - constant * rate) / (ohm + wires * duty**2)
        fed = (VOLT * duty - constant * rate) / ohm  # a motor that is driven feeds no supply
        ampere = np.where(duty * ampere < 0, fed, ampere)
        pull = pulls * np.sin(gain * angle + zero)
        rate = rate + STEP_S / inertia * (constant * ampere - viscous * rate - pull)
        rate = np.sign(rate) * np.maximum(np.abs(rate) - STEP_S / inertia * dry, 0.0)
        angle = angle + STEP_S * rate
    return STEP_S * EVERY * np.arange(len(seen)), np.array(seen).T


def tables_of(
    hidden: list[Hidden], seed: int, motion: tuple[np.ndarray, np.ndarray] | None = None
) -> list[BenchTest]:
    """Return the tables that a film of 240 pictures a second leaves of each of them.

    motion: what `moved` returned, if somebody has it.
    """
    t_s, angles = motion or moved(hidden)
    rng = np.random.default_rng(seed)
    sent = np.searchsorted([t for t, _ in SENT], t_s + 1e-9, side="right") - 1
    setpoint = np.radians([SENT[k][1] for k in sent])
    tables = []
    for one, angle in zip(hidden, angles, strict=True):
        noise = NOISE_RAD * rng.normal(size=t_s.size)
        seen = one.gain * angle + one.zero_rad + noise
        tables.append(BenchTest(t_s, setpoint, seen, STATED_RAD, load=one.load))
    return tables


def drawn(count: int, seed: int, loads: bool = True) -> list[Hidden]:
    """Return hidden hobby servos, with offsets, late logs, jitter, D terms and hanging loads."""
    rng, hidden = np.random.default_rng(seed), []
    for k, servo in enumerate(sn.servo().draws(count, seed)):
        line = servo.torque_limit_nm / servo.speed_limit_rad_s
        late_s = rng.uniform(0.0, 0.1)
        jitter_s = rng.uniform(0.0, 0.02, len(SENT) - 1) * (k % 2)
        load, moment = None, 0.0
        if loads and k % 4 == 1:
            distance = rng.uniform(0.05, 0.12)
            share = rng.uniform(0.1, 0.4)  # of the stalled torque
            load = Load(share * servo.torque_limit_nm / 9.81 / distance, distance)
        elif loads and k % 4 == 2:
            moment = servo.torque_limit_nm * rng.uniform(0.0, 0.15)
        derivative = max(rng.normal(0.0, 0.02), -0.5 * line / servo.stiffness_nm_rad)
        fields = {name: getattr(servo, name) for name in sn.Servo.__slots__}
        fields["damping_nms_rad"] = line + servo.stiffness_nm_rad * derivative
        hidden.append(
            Hidden(
                sn.Servo(**fields),
                math.radians(rng.uniform(-8.0, 8.0)),
                1.0,
                tuple((late_s + jitter_s).tolist()),
                load,
                moment,
                rng.uniform(0.0, 1 / servo.update_hz),
            )
        )
    return hidden
