"""The periodic state of a gait by Newton's method: speed, powers, stability, radius of its path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.checks import check_number
from ..base.errors import BadInput, NotConverged
from ..base.long_calls import threads_to_use
from ..base.rows import Plottable, Row, detail, two_digits
from ..base.vectors import Array
from ..model.core_model import check_parts, core_model
from ..model.gait import Gait, gait_name
from ..model.ground import Ground
from ..model.robot import Robot

if TYPE_CHECKING:
    from .sensitivities import Sensitivities


@dataclass(frozen=True, slots=True)
class Motion:
    """Hold a stable motion: its turn per cycle, and its displacement per cycle over the period."""

    turn_rad_per_cycle: float
    chord_m_s: float


@dataclass(frozen=True, slots=True)
class FromRest:
    """Hold whether a start from rest ends in the reported state, and a second stable motion."""

    reaches_reported: bool
    other: Motion | None


@dataclass(frozen=True, slots=True)
class Steady(Plottable):
    """Hold the periodic state of a gait (explicit model), into which the motion settles.

    Attributes
    ----------
    robot
        What crawls.
    ground
        Friction of what it crawls on.
    gait
        How its joints move.
    speed_m_s
        Along the path's mean circle, m/s. For a straight gait it is the displacement over a period,
        divided by the period. A gait that steers turns about a centre. In axes that turn evenly
        with it, the centre of mass has a mean place; radius_m, m, is its distance from the centre
        (inf when straight). Neither depends on the phase.
    chord_m_s
        |displacement over the period that begins at phase 0| / period, m/s. It depends on the
        phase.
    turn_rad_per_cycle
        Change of heading in a period, rad.
    power_w
        Net mean of P = -sum T_i phi_i', W.
    abs_power_w
        Mean of sum |P_i|, W.
    positive_power_w
        Mean of sum max(P_i, 0), W.
    error_estimate
        Relative error of the speed (near speed 0: over 1e-4 of body length times omega).
    power_error_w
        Error of power_w, W.
    positive_power_error_w
        Error of positive_power_w, W.
    turn_error_rad
        Error of the turn, rad.
    direction_rad
        Direction of travel, counted from the heading of link 1 at phase 0, rad.
    settling_time_s
        Time in which the slowest disturbance falls to 1/e, s; inf when it does not fall.
    settling_error
        Relative error of that time.
    sensitivities
        Per cents of speed for 1 % of seven numbers, where they were asked for.
    from_rest
        Whether a start from rest ends in this state (`reaches_reported`), and the `other`
        motion if the gait has two; None where that was not asked for, or not known.

    Notes
    -----
    settling_error is 1 in two cases: resting wheels leave almost nothing of a disturbance
    (multipliers below 1e-13), or several wheels stop at one moment, so there is no derivative. The
    true time is then between 0 and twice the one given.

    Three wheels at rest hold the whole chain, and three equations give their forces. If more than
    three could rest at once, the friction law picks three; the velocities are the same for any
    choice.

    If a wheel's speed comes so near to nothing that its stick or slip state is ambiguous, its dry
    friction is uncertain, and so are the joint torques, though hardly the speed or net power.
    positive_power_error_w covers both cases. It may be far larger than what was asked for:
    `power_doubt_text` then says so.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> s = sn.steady_gait(robot, ground, gait)
    >>> bool(s.error_estimate < 1e-5), bool(s.positive_power_w > s.power_w)
    (True, True)
    """

    robot: Robot
    ground: Ground
    gait: Gait
    speed_m_s: float
    power_w: float
    abs_power_w: float
    positive_power_w: float
    turn_rad_per_cycle: float
    chord_m_s: float
    error_estimate: float
    power_error_w: float
    positive_power_error_w: float
    turn_error_rad: float
    direction_rad: float
    settling_time_s: float
    settling_error: float
    _body_velocity: tuple[float, ...] = field(repr=False)
    _monodromy: tuple[float, ...] = field(repr=False)
    sensitivities: Sensitivities | None = field(default=None, repr=False, compare=False)
    from_rest: FromRest | None = field(default=None, repr=False, compare=False)

    @property
    def body_velocity(self) -> Array:
        """Return the velocity (3,) at phase 0: of the centre of mass, m/s, and theta_1', rad/s."""
        return np.array(self._body_velocity)

    @property
    def monodromy(self) -> Array:
        """Return the monodromy matrix (3, 3) of (Vx, Vy, L), m/s and kg m^2/s, over a period."""
        return np.array(self._monodromy).reshape(3, 3)

    @property
    def abs_power_error_w(self) -> float:
        """Return the estimated error of abs_power_w = 2 positive_power_w - power_w, W."""
        return 2 * self.positive_power_error_w + self.power_error_w

    @property
    def radius_m(self) -> float:
        """Return the radius of the mean circle, m; inf for a gait that goes straight."""
        turn_rad_s = abs(self.turn_rad_per_cycle) / self.gait.period_s
        return self.speed_m_s / turn_rad_s if turn_rad_s > 0 else math.inf

    @property
    def radius_error_m(self) -> float:
        """Return the estimated error of radius_m, m; inf if the turn may be 0."""
        turn_rad = abs(self.turn_rad_per_cycle)
        if self.turn_error_rad >= turn_rad or math.isinf(self.radius_m):
            return math.inf if turn_rad > 0 else 0.0
        share = self.turn_error_rad / turn_rad
        return self.radius_m * (self.error_estimate + share) / (1 - share)

    @property
    def floquet_multipliers(self) -> NDArray[np.complex128]:
        """Return the three Floquet multipliers, the largest in magnitude first.

        The largest determines the settling time. One that is smaller by ten decades or more has no
        correct digit.
        """
        values = np.linalg.eigvals(self.monodromy).astype(complex)
        return values[np.argsort(-abs(values))]

    @property
    def stable(self) -> bool:
        """Tell whether small disturbances die out."""
        return math.isfinite(self.settling_time_s)

    def power_doubt_text(self, rtol: float = 1e-6) -> str:
        """Return which power is not as well known as was asked for, or "".

        Parameters
        ----------
        rtol
            The relative accuracy asked for.

        Returns
        -------
        str
            A sentence with the power in W and its error in %.

        Examples
        --------
        >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
        >>> ground = sn.Ground(ct=0.1, cn=10.0)
        >>> sn.steady_gait(robot, ground, sn.Gait(0.5, 1.4, 5.0)).power_doubt_text()
        ''
        """
        share = self.positive_power_error_w / max(self.positive_power_w, 1e-300)
        # An error below 1e-4 of the positive power needs no words.
        if share <= max(10 * rtol, 1e-4):
            return ""
        return (
            f"the power without regeneration, {self.positive_power_w:.3g} W, is known to "
            f"{100 * share:.2g} % only, and so is that of each joint's absolute value; speed and "
            "net power are known as asked"
        )

    def in_words(self) -> str:
        """Return the speed as a builder asks for it."""
        return f"About {two_digits(self.speed_m_s)} m/s with ideal joints; servos may be slower."

    def rows(self) -> list[Row]:
        """Return speed, powers, turn, settling time and error."""
        straight = math.isinf(self.radius_m)
        turn = math.degrees(self.turn_rad_per_cycle)
        return [
            Row("gait", "", words=gait_name(self.gait)),
            Row("speed, ideal joints", "m/s", self.speed_m_s),
            Row("net power", "W", self.power_w),
            detail("power, each joint's absolute value", "W", self.abs_power_w),
            detail("power, no regeneration", "W", self.positive_power_w),
            Row("turn per cycle", "deg", turn, detail=straight),
            Row(
                "radius of the path",
                "m",
                self.radius_m,
                detail=straight,
                words="straight" if straight else "",
            ),
            detail("settling time (to 1/e)", "s", self.settling_time_s),
            detail("error of the speed, relative", "", self.error_estimate),
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers, for JSON."""
        multipliers = self.floquet_multipliers
        names = (
            "speed_m_s",
            "power_w",
            "abs_power_w",
            "positive_power_w",
            "turn_rad_per_cycle",
            "chord_m_s",
            "radius_m",
            "error_estimate",
            "power_error_w",
            "abs_power_error_w",
            "positive_power_error_w",
            "turn_error_rad",
            "radius_error_m",
            "settling_time_s",
            "settling_error",
        )
        values = {name: getattr(self, name) for name in names} | {
            "floquet_multipliers": [[m.real, m.imag] for m in multipliers.tolist()]
        }
        if self.sensitivities is not None:
            values["sensitivities"] = self.sensitivities.to_dict()
        if self.from_rest is not None:
            values["from_rest"] = asdict(self.from_rest)
        return values


def speed_floor_m_s(robot: Robot, omega_rad_s: float) -> float:
    """Return 1e-4 of body length times rate, m/s: errors of lower speeds are relative to it."""
    return _core.SPEED_FLOOR * omega_rad_s * robot.links * robot.link_length_m


def relative_error(error: float, speed: float, robot: Robot, gait: Gait) -> float:
    """Return error over speed, or over speed_floor_m_s if that is higher."""
    return error / max(speed, speed_floor_m_s(robot, gait.omega_rad_s))


def check_ground(ground: Ground, rtol: float) -> None:
    """Raise BadInput for ground without friction, and for an rtol that the solver cannot reach."""
    finest = 1e-12 if ground.smooth else 1e-7
    check_number("rtol", rtol, finest, 0.1)
    if ground.cn == 0 and max(ground.ct_forward, ground.ct_backward) == 0 and not ground.dry:
        raise BadInput(
            "there is no friction at all (ct, cn, ft0 and fn0 are 0): nothing damps the start, so "
            "there is no one periodic state; give some friction, or use simulate"
        )


def steady_gait(
    robot: Robot, ground: Ground, gait: Gait, *, rtol: float = 1e-6, powers: bool = True
) -> Steady:
    """Solve for the periodic state of a gait under imposed joint angles, explicit model.

    Newton's method on the period map, with half a period where mirror symmetry allows it; dry
    ground as the set-valued law with exact sticking. rtol: wanted relative accuracy of speed and
    net power, 0.1 to 1e-12 (dry ground: to 1e-7, net power to 10 rtol). The other powers have
    error estimates of their own, for which a state is never refused. powers=False leaves them out
    (0) and is faster. Raises BadInput, and NotConverged whose `best` is the best Steady found, with
    its error.
    """
    check_parts(robot, ground, gait)
    check_ground(ground, rtol)
    s = _core.steady(core_model(robot, ground, gait), rtol, powers)
    state = from_core(robot, ground, gait, s)
    if not s.converged:
        raise NotConverged(_not_found(state, rtol), best=state)
    return state


def state_near(
    robot: Robot, ground: Ground, gait: Gait, *, rtol: float, powers: bool, start: Steady | None
) -> Steady:
    """Return the best state found of a gait, whatever its error.

    start: state of a similar gait, from which Newton's method starts. On dry ground the first state
    found is then returned; it mostly agrees to rtol, and its error is not estimated.
    """
    model = core_model(robot, ground, gait)
    if start is None:
        state = _core.steady(model, rtol, powers)
    else:
        velocity = start.body_velocity * (gait.omega_rad_s / start.gait.omega_rad_s)
        begin = [velocity.tolist()]
        (state,) = _core.neighbours(model, [model], rtol, powers, 1, True, begin)
    return from_core(robot, ground, gait, state)


def drawn_states(
    robot: Robot,
    middle_draw: tuple[Ground, Gait],
    draws: Sequence[tuple[Ground, Gait]],
    rtol: float = 1e-3,
) -> list[Steady]:
    """Return the periodic state of each draw, speed to rtol, started from that of middle_draw.

    Raises BadInput and NotConverged as `steady_gait` does.
    """
    for ground, _ in (middle_draw, *draws):
        check_ground(ground, rtol)
    middle, *models = (core_model(robot, *draw) for draw in (middle_draw, *draws))
    threads = min(threads_to_use(), max(len(models), 1))
    states = _core.neighbours(middle, models, rtol, False, threads)
    return [
        from_core(robot, *draw, state)
        if state.converged
        else steady_gait(robot, *draw, rtol=rtol, powers=False)
        for draw, state in zip(draws, states, strict=True)
    ]


def from_core(robot: Robot, ground: Ground, gait: Gait, s: _core.SteadyState) -> Steady:
    """Return the Steady of a state that the core found."""
    error = relative_error(s.speed_error, s.speed, robot, gait)
    settling = math.inf, 0.0
    if s.log_largest_multiplier < 0:
        double_root_error = 3e-8  # error of two nearly equal multipliers, some sqrt(epsilon)
        settling = (
            gait.period_s / -s.log_largest_multiplier,
            (s.log_multiplier_error + double_root_error) / -s.log_largest_multiplier,
        )
    return Steady(
        robot,
        ground,
        gait,
        s.speed,
        s.power,
        s.abs_power,
        s.positive_power,
        s.turn,
        s.chord,
        error,
        s.power_error,
        s.positive_power_error,
        s.turn_error,
        s.direction,
        *settling,
        s.start,
        s.monodromy,
    )


def _not_found(best: Steady, rtol: float) -> str:
    """Return the message of NotConverged: what was found, and what to do."""
    gait, follow = gait_name(best.gait), "follow the motion in time with simulate"
    if math.isinf(best.error_estimate):
        return f"no periodic state found for {gait}, nor anything near one; {follow}"
    details = f", its net power an error of {best.power_error_w:.1g} W"
    if best.error_estimate > rtol:
        details = ""
    elif not best.stable:
        details = ", but disturbances of it grow: no motion stays there"
    return (
        f"no periodic state found to rtol {rtol:g} for {gait}: the best has a speed of "
        f"{best.speed_m_s:.6g} m/s with a relative error of {best.error_estimate:.1g}{details}; "
        f"ask for a larger rtol, or {follow}"
    )
