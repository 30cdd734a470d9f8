"""How a periodic state changes with gait, friction and robot: derivatives with their errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.errors import BadInput, NotConverged
from ..base.long_calls import TimeLimit
from ..base.rows import Result
from ..base.vectors import Array
from ..model.core_model import core_model
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot

Parts = tuple[Robot, Ground, Gait]
QUANTITIES = ("speed_m_s", "power_w", "positive_power_w", "turn_rad_per_cycle")

_IN_CORE = ("speed", "power", "positive_power", "turn")
_OF_GAIT = ("alpha_rad", "beta_rad", "omega_rad_s", "offset_rad", "joint_gain", "joint_shift_rad")
_OF_GROUND = ("ct", "cn", "ft0", "fn0")
_OF_ROBOT = ("link_mass_kg", "link_inertia_kg_m2", "link_length_m")
_STEP = 1e-3  # of the parameter, or rad
_HALVINGS = 6
_RTOL = 1e-7
_SMOOTH = 1e-2  # both sides agree to this part of the derivative: it is smooth
_UNSEEN = 0.1  # of a jump: what the mean of both sides may be off by where nothing has kinks
_BENT = 0.5  # and elsewhere: a kink within the step puts the mean off by half the jump
_SAME_JUMP = 0.75  # a smooth function's jump halves with the step
_CURVED = 3e-6  # of a derivative: the square of a step, which the jump of an odd one does not show
_AHEAD = 1.5  # of the last change of a side: what is left of it falls with the step or its root
_LEFT = 4.0  # and the error of that, also where the kink is a little aside


@dataclass(frozen=True, slots=True)
class Sensitivities(Result):
    """Hold the derivatives of a periodic state by the parameters that make it.

    Printed, it is a table of what 1 % more of each parameter changes, or 1 deg more of an angle. At
    a kink less changes other things than more, and has a row of its own.

    Attributes
    ----------
    names, values
        Of the P parameters, as Robot, Ground and Gait name them, SI units and rad;
        `joint_gain[2]` is the third joint from the tail. A parameter at the end of its range (a
        friction of 0) is left out.
    derivatives
        (P, Q): of speed_m_s, power_w, positive_power_w and turn_rad_per_cycle, by the parameter.
    errors
        (P, Q): estimated errors of derivatives. Where a wheel's mode changes at the point, half of
        the jump.
    sides, side_errors
        (P, Q, 2): the derivatives towards less and towards more of the parameter, and their
        estimated errors. Both sides are the derivative unless there is a kink.
    kinks
        (P,): whether the two sides of a quantity differ by more than 1 %: a wheel's mode changes
        at the point, or nearer to it than 2e-5 of the parameter (or rad).
    at
        (Q,): the quantities themselves.
    floor_m_s
        Speed below which the gait has none to take per cents of, m/s.

    Notes
    -----
    Mass, inertia and length are separate parameters: the others keep their values.
    """

    names: tuple[str, ...]
    values: Array
    derivatives: Array
    errors: Array
    sides: Array
    side_errors: Array
    kinks: NDArray[np.bool_]
    at: Array
    floor_m_s: float

    def in_words(self) -> str:
        """Return what the table shows."""
        kinks = (
            " Kink: at this point a wheel begins or ceases to rest, so a little less and a little "
            "more each have a row."
        )
        return (
            "What a little more of each changes; ideal joints, others kept. Power+: without "
            "regeneration; turn: in a cycle." + kinks * bool(self.kinks.any())
        )

    def table(self, verbose: bool = True) -> tuple[list[str], list[list[str]]]:
        """Return heads and cells, a row for each parameter, two at a kink."""
        speed = "speed, %" if self.at[0] > self.floor_m_s else "speed, mm/s"
        heads = ["parameter", "more by", speed, "power, %", "power+, %", "turn, deg"]
        cells = []
        for k, name in enumerate(self.names):
            angle = name.endswith("_rad") or "_rad[" in name
            more = "1 deg" if angle else "1 %"
            step = math.radians(1) if angle else 0.01 * self.values[k]
            if not self.kinks[k]:
                changes = self._changes(step, self.derivatives[k], self.errors[k])
                cells.append([name, more, *changes])
                continue
            for side, sign in enumerate(("-", "")):
                changes = self._changes(
                    step * (2 * side - 1), self.sides[k, :, side], self.side_errors[k, :, side]
                )
                cells.append([f"{name} (kink)", sign + more, *changes])
        return heads, cells

    def _changes(self, step: float, derivatives: Array, errors: Array) -> list[str]:
        """Return what a step changes in the units of the table, 0 within the error."""
        units = [*(self.at[:3] / 100), math.radians(1)]
        if self.at[0] <= self.floor_m_s:
            units[0] = 1e-3
        return [
            f"{by * step / unit:+.2g}" if abs(by) > error else "0"
            for by, error, unit in zip(derivatives, errors, units, strict=True)
        ]

    def elasticities(self, quantity: str = "speed_m_s") -> Array:
        """Return the change of a quantity, in per cent, for 1 % of each parameter, (P,)."""
        column = QUANTITIES.index(quantity)
        return self.derivatives[:, column] * self.values / self.at[column]

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as plain numbers, for JSON, by parameter."""
        return {
            name: {"value": self.values[k].item(), "kink": bool(self.kinks[k])}
            | {
                quantity: {
                    "derivative": self.derivatives[k, q].item(),
                    "error": self.errors[k, q].item(),
                    "sides": self.sides[k, q].tolist(),
                    "side_errors": self.side_errors[k, q].tolist(),
                }
                for q, quantity in enumerate(QUANTITIES)
            }
            for k, name in enumerate(self.names)
        }


@dataclass(frozen=True)
class Parameter:
    """A number of robot, ground or gait: its value, its step, and the parts with another value."""

    name: str
    value: float
    step: float
    moved: Callable[[float], Parts]

    @property
    def inside(self) -> bool:
        """Tell whether the value has room on both sides."""
        if self.step == 0:
            return False
        try:
            for sign in (-1, 1):
                self.moved(self.value + sign * self.step)
        except BadInput:
            return False
        return True


def differentiate(
    robot: Robot, ground: Ground, gait: Gait, floor_m_s: float = 0.0
) -> Sensitivities:
    """Differentiate the periodic state of a gait by each of its parameters.

    Each parameter is moved to both sides. The state there is solved for from the state here, which
    is so near that Newton's method needs one cycle or two. Where the two sides differ by more than
    a smooth function would, the step is halved until they agree; where they never do there is a
    kink. floor_m_s: as in Sensitivities. Raises BadInput: a gait that does not move; NotConverged,
    after 20 s, too.
    """
    if gait.alpha_rad == 0:
        raise BadInput("alpha_rad is 0: a robot that does not move has no sensitivities")
    limit = TimeLimit(
        "the derivatives of this state",
        "ask for the state without sensitivities, or for those of a gait a little aside",
    )
    here, moved = (robot, ground, gait), parameters(robot, ground, gait)
    steps = np.array([p.step for p in moved])
    sides, noise, at = _differences(here, moved, steps, limit)
    unseen = _UNSEEN if ground.smooth else _BENT
    changes, side_changes = unseen * _jumps(sides), np.zeros_like(sides)
    kinked = np.zeros(changes.shape, bool)
    for _ in range(_HALVINGS):
        rough = np.flatnonzero((_jumps(sides) > _allowed(sides, noise)).any(axis=1))
        if not rough.size:
            break
        steps[rough] /= 2
        near, near_noise, _ = _differences(here, [moved[k] for k in rough], steps[rough], limit)
        far = sides[rough]
        kinked[rough] = _jumps(near) > _SAME_JUMP * _jumps(far)
        changes[rough] = abs(near.mean(axis=2) - far.mean(axis=2)) + unseen * _jumps(near)
        side_changes[rough] = near - far
        sides[rough], noise[rough] = near, near_noise
    jumps, slopes = _jumps(sides), sides.mean(axis=2)
    kinks = np.asarray((kinked & (jumps > _allowed(sides, noise))).any(axis=1))
    errors = noise[..., 1] + np.where(kinks[:, None], jumps / 2, changes) + _CURVED * abs(slopes)
    apart = kinks[:, None, None]  # then all quantities' sides are told as they are
    return Sensitivities(
        tuple(p.name for p in moved),
        np.array([p.value for p in moved]),
        slopes,
        errors,
        np.where(apart, sides + _AHEAD * side_changes, slopes[..., None]),
        np.where(
            apart, _LEFT * (abs(side_changes) + noise[..., :1]), (errors + jumps / 2)[..., None]
        ),
        kinks,
        at,
        floor_m_s,
    )


def _jumps(sides: Array) -> Array:
    return abs(sides[..., 1] - sides[..., 0])


def _allowed(sides: Array, noise: Array) -> Array:
    """Return how much the sides may differ where nothing is wrong."""
    return _SMOOTH * abs(sides).max(axis=2) + 2 * noise[..., 0]


def _differences(
    here: Parts, moved: list[Parameter], steps: Array, limit: TimeLimit
) -> tuple[Array, ...]:
    """Return differences to both sides, their noise, both (P, Q, 2), and the state here, (Q,).

    Noise is what the claims of the states make of either side, and of the mean of both: the state
    here counts in a side alone. Raises NotConverged where a state beside this one has no solution.
    """
    at = [
        (p, p.value + sign * step) for p, step in zip(moved, steps, strict=True) for sign in (-1, 1)
    ]
    models = [core_model(*here), *(core_model(*p.moved(value)) for p, value in at)]
    states = _core.neighbours(models[0], models, _RTOL, True, 1, progress=limit)
    values, claims = (
        np.array([[getattr(state, name + what) for name in _IN_CORE] for state in states])
        for what in ("", "_error")
    )
    for (p, value), claim in zip(at, claims[1:], strict=True):
        if not np.isfinite(claim).all():
            raise NotConverged(
                f"no periodic state found beside this gait, at {p.name} = {value:.9g}: there are "
                "no derivatives; ask for the state without sensitivities"
            )
    beside, claimed = (v[1:].reshape(-1, 2, len(QUANTITIES)) for v in (values, claims))
    sides = (beside - values[0]) * np.array([-1, 1])[:, None] / steps[:, None, None]
    mean = claimed.mean(axis=1) / steps[:, None]
    noise = np.stack([mean + claims[0] / steps[:, None], mean], axis=2)
    return sides.transpose(0, 2, 1), noise, values[0]


def parameters(robot: Robot, ground: Ground, gait: Gait) -> list[Parameter]:
    """Return the parameters of a state that have room on both sides."""
    gain, shift = (tuple(v.tolist()) for v in gait.joint_factors(robot.links - 1))
    here = robot, ground, replace(gait, joint_gain=gain, joint_shift_rad=shift)
    shares = ("omega_rad_s", "joint_gain")  # whose steps are in proportion, as the robot's
    every = [
        *(p for name in _OF_GAIT for p in _numbers(here, 2, name, 0.0 if name in shares else 1.0)),
        *(p for name in _OF_GROUND for p in _numbers(here, 1, name, 1e-6)),
        *(p for name in _OF_ROBOT for p in _numbers(here, 0, name, 0.0)),
    ]
    return [p for p in every if p.inside]


def _numbers(here: Parts, part: int, name: str, least: float) -> Iterator[Parameter]:
    """Give each number of a part's field: one, a joint's, or both ways of a ratchet's.

    least: of what a step is a share of, but of a ratchet's.
    """
    field = getattr(here[part], name)
    several = isinstance(field, tuple)
    for place, number in enumerate(field if several else (field,)):

        def moved(value: Any, place: int = place) -> Parts:
            if several:
                value = (*field[:place], value, *field[place + 1 :])
            parts: list[Any] = list(here)
            parts[part] = replace(here[part], **{name: value})
            robot, ground, gait = parts
            return robot, ground, gait

        ending = ("_forward", "_backward")[place] if part == 1 else f"[{place}]"
        step = _STEP * max(abs(number), 0.0 if several and part == 1 else least)
        yield Parameter(name + ending * several, number, step, moved)
