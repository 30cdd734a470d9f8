"""The speed of a gait whose joints are moved by servos, and what the servo leaves uncertain."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any

import numpy as np

from .. import _core
from ..base.checks import check_kind
from ..base.errors import NotConverged
from ..base.long_calls import Progress, in_threads, keep_running
from ..base.rows import Result, Row, detail, ranged, two_digits
from ..base.vectors import Array
from ..model.core_model import core_model
from ..model.drives import Servo, ServoKind, core_servo
from ..model.gait import gait_name
from ..servos.speed_limit import (
    highest_hz,
    is_too_fast,
    joint_rate_rad_s,
    no_load_rad_s,
    too_fast_text,
)
from .steady import Steady, relative_error, steady_gait

LEAST_AMPLITUDE = 0.2  # share of the gait's: below it the typical servo is too weak for the robot


def band(drawn: Array | Sequence[float]) -> tuple[float, float]:
    """Return the ends that hold 95 % of what the draws were drawn from.

    Harrell and Davis' quantiles: means of all draws in order, weighted by how likely each of them
    is the quantile of n. One draw alone decides no end. They lie half a draw too far inside, so
    the quantile is taken half a draw farther out: the share held is then right from 64 draws on.
    """
    from scipy.special import betainc

    n = len(drawn)
    # Of few draws the outermost one is the end.
    tail = max(((n + 1) * 0.025 - 0.5) / n, 1e-6)
    weight = np.diff(betainc((n + 1) * tail, (n + 1) * (1 - tail), np.arange(n + 1) / n))
    ordered = np.sort(np.ravel(drawn))
    return float(weight @ ordered), float(weight[::-1] @ ordered)


@dataclass(frozen=True, slots=True)
class ServoSteady(Result):
    """Hold the speed of a gait with ideal joints and with servos.

    Attributes
    ----------
    ideal
        The periodic state of joints that follow the gait exactly.
    servo
        The servo or the kind of servo.
    speed_m_s
        Speed with the (typical) servo, m/s: mean over all phases between the board's frames and the
        gait, which have no period in common.
    spread_m_s
        Half the range of the speed over these phases, m/s.
    error_estimate
        Numerical error of the speed, relative: step length, phases, and what settling leaves.
    amplitude_ratio
        First harmonic of the joints' angles over the gait's, mean over joints.
    lag_rad
        Lag of that harmonic behind the gait, rad.
    ripple_rad_s
        Rms of the joints' rates beside the first harmonic, rad/s.
    power_w
        Mean net power that the gears give to the joints, W.
    turn_rad_per_cycle
        Change of heading in a period, rad.
    samples_m_s
        Speeds of servos drawn from the kind, m/s; () for a servo that is exact, and where the gait
        is too fast. low_m_s and high_m_s are their 95 % interval, or the spread of an exact one.
        Both are NaN for a kind in doubt without samples.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> s = sn.steady_gait(robot, ground, gait, servo=sn.Servo())
    >>> s.speed_m_s < s.ideal.speed_m_s
    True
    """

    ideal: Steady
    servo: Servo | ServoKind
    speed_m_s: float
    spread_m_s: float
    error_estimate: float
    amplitude_ratio: float
    lag_rad: float
    ripple_rad_s: float
    power_w: float
    turn_rad_per_cycle: float
    samples_m_s: tuple[float, ...] = ()

    @property
    def name(self) -> str:
        """Return the name of the kind of servo."""
        return self.servo.name if isinstance(self.servo, ServoKind) else "as given"

    @property
    def low_m_s(self) -> float:
        """Return the lower end of the band that the servo leaves, m/s."""
        return self._ends[0]

    @property
    def high_m_s(self) -> float:
        """Return the upper end of the band that the servo leaves, m/s."""
        return self._ends[1]

    @property
    def joint_rate_over_no_load(self) -> float:
        """Return the fastest joint rate over the typical servo's no-load speed."""
        return joint_rate_rad_s(self.ideal.gait) / no_load_rad_s(self.servo)

    @property
    def follows(self) -> bool:
        """Return whether the gait is not too fast for the typical servo, which moves the robot."""
        return self.moves and not is_too_fast(self.ideal.gait, self.servo)

    @property
    def moves(self) -> bool:
        """Return whether the typical servo reaches a fifth of the gait's amplitude."""
        return self.amplitude_ratio >= LEAST_AMPLITUDE

    @property
    def highest_hz(self) -> float:
        """Return the frequency, Hz, up to which such a gait is not too fast."""
        return highest_hz(self.ideal.gait, self.servo)

    @property
    def _ends(self) -> tuple[float, float]:
        in_doubt = isinstance(self.servo, ServoKind) and not self.servo.exact
        if not self.follows or (in_doubt and not self.samples_m_s):
            return math.nan, math.nan
        if self.samples_m_s:
            return band(self.samples_m_s)
        return max(self.speed_m_s - self.spread_m_s, 0.0), self.speed_m_s + self.spread_m_s

    def in_words(self) -> str:
        """Return what a builder may expect: a speed with its band, or why it has none."""
        if not self.ideal.gait.alpha_rad:
            return "Joints that do not swing (alpha is 0) move no robot."
        if not self.moves:
            return (
                f"Typical {self.name} servos cannot move this robot: its joints reach "
                f"{self.amplitude_ratio:.0%} of the gait's amplitude. So it has no band."
            )
        if too_fast := too_fast_text(self.ideal.gait, self.servo):
            return too_fast
        speed = ranged(self.speed_m_s, "m/s", *self._ends)
        if math.isnan(self.low_m_s):
            speed = f"{two_digits(self.speed_m_s)} m/s"
        text = f"About {speed} with typical servos; "
        text += f"ideal joints {two_digits(self.ideal.speed_m_s)}."
        return f"{text} {self.servo.remark}".rstrip() if isinstance(self.servo, ServoKind) else text

    def rows(self) -> list[Row]:
        """Return speed with its band, what becomes of the joints, voltage, source and error."""
        share = 100 * self.joint_rate_over_no_load
        rows = [
            Row("servos", "", words=self.name),
            Row("amplitude that joints reach", "%", 100 * self.amplitude_ratio),
            Row("lag of the joints", "deg", math.degrees(self.lag_rad)),
            Row("fastest joint rate, of the no-load speed", "%", share),
            detail("error of the speed, relative", "", self.error_estimate),
        ]
        if not self.follows or not math.isnan(self.low_m_s):  # servos that move no robot: no speed
            speed_m_s = self.speed_m_s if self.moves else math.nan
            rows.insert(1, Row("speed, typical servo", "m/s", speed_m_s, *self._ends))
        if isinstance(self.servo, ServoKind):
            rows.append(Row("voltage at the plug", "V", words=self.servo.volts_in_words))
            rows.append(detail("source", "", words=self.servo.source))
        return rows

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers, for JSON; None for what is not known."""
        derived = "low_m_s", "high_m_s", "joint_rate_over_no_load", "follows", "highest_hz"
        names = "name", *self.__match_args__[2:10], *derived
        values: dict[str, Any] = {name: getattr(self, name) for name in names}
        if math.isnan(self.low_m_s):
            values |= {"low_m_s": None, "high_m_s": None}
        return values


def servo_state(
    ideal: Steady,
    servo: Servo,
    rough: bool = False,
    slow: float = _core.SPEED_FLOOR,
    progress: Callable[[float, float], None] | None = None,
) -> Any:
    """Return the core's answer for one servo: speed, spread, error, amplitude, lag, ...

    rough: 1 or 2 % off in a quarter of the time, with a loop of at most 500 Hz and without an
    error; for searches. slow: of body length times rate; a slower speed is known to a part of this
    one. progress: called with the cycles done and those in all; may raise to stop.
    """
    # Two thousand steps a cycle, of 1 to 2 ms.
    fine_s = min(max(ideal.gait.period_s / 2000, 1e-3), 2e-3)
    step = min(4e-3 if rough else fine_s, servo.frame_s / 4)
    if rough:
        servo = replace(servo, update_hz=min(servo.update_hz, 500.0))
    return _core.servo_gait(
        core_model(ideal.robot, ideal.ground, ideal.gait),
        core_servo(servo),
        tuple(ideal.body_velocity),
        tuple(ideal.monodromy.ravel()),
        step,
        rough,
        slow,
        progress or (lambda _done, _all: keep_running()),
    )


def servo_speed(ideal: Steady, servo: Servo, rough: bool = False) -> float:
    """Return the speed with a servo, m/s, of a gait whose ideal periodic state is known."""
    return servo_state(ideal, servo, rough).speed


def ripple_share(ideal: Steady, servo: Servo, rough: bool = False) -> float:
    """Return the share of the ideal speed that joints of the seen amplitude have with a servo.

    A film showed each joint's amplitude and phase, so that they are not counted again: the speed is
    compared with that of ideal joints which make the same ones. The joints' mean lag is left out:
    it shifts the whole motion in time.
    """
    moved, gait = servo_state(ideal, servo, rough), ideal.gait
    shift = np.array(moved.shift)
    gain, gait_shift = gait.joint_factors(len(shift))
    gain = np.clip(gain * np.array(moved.gain), 0.0, 2.0)
    turned = np.exp(1j * (gait_shift + shift))
    mean = np.angle(turned @ gain) if gain.any() else 0.0
    shifts = np.angle(turned * np.exp(-1j * mean))
    sines = replace(gait, joint_gain=tuple(gain.tolist()), joint_shift_rad=tuple(shifts.tolist()))
    filmed = steady_gait(ideal.robot, ideal.ground, sines, rtol=1e-3, powers=False)
    return moved.speed / max(filmed.speed_m_s, 1e-9)


def drawn_servo_speed(ideal: Steady, servo: Servo, rough: bool) -> float:
    """Return the speed with a servo, m/s; of a slow gait to a part of 0.5 % of length x rate."""
    return servo_state(ideal, servo, rough, slow=5e-3).speed


def drawn_servo_speeds(
    ideal: Sequence[Steady],
    servos: Sequence[Servo],
    threads: int | None = None,
    value: Callable[[Steady, Servo, bool], float] = drawn_servo_speed,
    progress: Progress | None = None,
    fine_count: int = 8,
) -> Array:
    """Return the speed of each draw with its servo, m/s, by rough states corrected by fine ones.

    ideal: the draws with ideal joints. value: what is wanted in place of the speed. progress:
    called with 1 after each rough state. A rough state costs a quarter of a fine one or less and is
    mostly 1 % off. fine_count: draws that are solved finely, those at both ends, which make the
    ends of a band, and others between; 0: none. The median ratio there puts the others right. Where
    one would then still be off by more than 15 % of the scatter of all, the eighth of the draws at
    either end, and of few draws every one, is solved finely.
    """

    def solved(places: Sequence[int], rough: bool, progress: Progress | None = None) -> Array:
        return np.array(
            in_threads(lambda k: value(ideal[k], servos[k], rough), places, progress, threads)
        )

    indices = range(len(servos))
    if len(servos) // 2 <= fine_count:
        return solved(indices, False)
    values = solved(indices, True, progress)
    if not fine_count:
        return values
    inside = np.linspace(1, len(servos) - 2, fine_count - 2).round().astype(int)
    order = np.argsort(values)
    picked = order[[0, *inside, -1]]
    fine = solved(picked.tolist(), False)
    values *= np.median(fine / np.maximum(values[picked], 1e-12))
    doubtful = np.abs(values[picked] - fine).max() > 0.15 * values.std()
    values[picked] = fine
    if doubtful:
        eighth = len(servos) // 8
        unsolved = np.setdiff1d(order[np.r_[:eighth, -eighth:0]], picked)
        values[unsolved] = solved(unsolved.tolist(), False)
    return values


def with_servo(
    ideal: Steady,
    servo: Servo | ServoKind,
    draws: int = 512,
    progress: Callable[[float], object] | None = None,
    threads: int | None = None,
) -> ServoSteady:
    """Return the speed that servos leave of a gait's; draws: so many of an uncertain kind.

    Servos make the joints lag and their rates ripple at the frames' rate; on dry ground the ripple
    loosens wheels which should hold. Time steps with impulses for all that is dry, and a secant
    method to the fixed point of the cycle. progress: called with the share of the typical servo's
    state that is done, and of the draws. Raises BadInput, and NotConverged with the best state.
    """

    def tell(done: float, total: float) -> None:
        keep_running()
        if progress is not None:
            progress(min(done / total, 1.0))

    check_kind("servo", servo, Servo, ServoKind)
    typical = servo.servo if isinstance(servo, ServoKind) else servo
    s = servo_state(ideal, typical, progress=tell)
    if math.isnan(s.speed):
        raise NotConverged(
            f"a servo of stiffness {typical.stiffness_nm_rad:g} N m/rad on links of inertia "
            f"{ideal.robot.inertia_kg_m2:g} kg m^2 would take more steps than anybody waits for; "
            "give it a rotor (armature_kg_m2), which real ones have"
        )
    error = relative_error(s.error, s.speed, ideal.robot, ideal.gait)
    driven = ServoSteady(
        ideal, servo, s.speed, s.spread, error, s.amplitude, s.lag, s.ripple, s.power, s.turn
    )
    if s.hunts:
        raise NotConverged(
            f"speed not defined: the servos' loops hunt, and {gait_name(ideal.gait)} moves at "
            f"{s.speed - s.spread:.2g} to {s.speed + s.spread:.2g} m/s, by how it begins; use "
            "servos with more damping, or a gait that asks less of them",
            best=driven,
        )
    if not s.converged:
        raise NotConverged(
            f"the motion of {gait_name(ideal.gait)} with servos does not settle to a speed: the "
            f"best is {s.speed:.6g} m/s; follow it in time: `serpenoid simulate --servo NAME`",
            best=driven,
        )
    if not isinstance(servo, ServoKind) or servo.exact or draws == 0 or not driven.follows:
        return driven
    number = count(1)
    speeds = drawn_servo_speeds(
        [ideal] * draws,
        servo.draws(draws),
        threads,
        progress=lambda _: tell(next(number), draws),
    )
    return replace(driven, samples_m_s=tuple(speeds.tolist()))
