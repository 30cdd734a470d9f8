"""Stations on a belt: readings of one force balance each, with the errors that they share.

A robot that holds its station at slip v has m g sin(gamma) = A v + B. The true speed of each
reading is solved for by hand (errors in variables); what is left is the distance to the line,

    r_i = (m g sin(gamma_i - z) - A v_i - B) / s_i,
    s_i^2 = (m g cos(gamma_i - z) sg)^2 + (A sv)^2.

A robot that still drifted when it was read has -m_e f of its track instead of A v (`tracks`), and
the track's error in s_i. Shared are the bends' errors, the inclinometer's zero z, its roundings
(`rounding`), the scale of the belt's speed, and links off their path (`shared`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...session.session import Session
from .bends import Bends, frictions_in, resistance
from .rounding import shared_rounding
from .shared import FRICTIONS, rolling_share
from .tracks import Tracks
from .unknowns import Floats, Unknown, Values, Whole

# Taken where a set-up claims a zero without error: an undeclared 0.1 degrees would leave ft0's 95 %
# interval with 17 % coverage, so that the prior is never absent.
ZERO_SIGMA_RAD = math.radians(0.1)
_LEAST_N = 1e-12  # of a reading's standard deviation, where frictions are 0 and nothing else errs


@dataclass(frozen=True, eq=False)
class Stations:
    """The kept stations of a session, a block of a posterior.

    incline_rad (as shown, less the zero where that was measured), slip_m_s, incline_sigma_rad (what
    is a reading's alone), speed_sigma_m_s: per reading. rounding: per reading, which of
    rounding_sigma_rad's errors its incline has; -1 where that is its alone. rounding_draws: of
    these, (N, errors), in sigmas. zero_sigma_rad: per reading, of what remains of the
    inclinometer's zero, common to all. belt_sigma: relative, of the
    belt's scale, where pushes beside the stations tell it; else 0. tracks: places of short
    readings, whose slip_m_s is the mean. inertia_n, inertia_sigma_n: per reading, the force that
    changes its speed, roughly, and its standard deviation; 0 where it was held.
    """

    numbers: Whole
    bends: Bends
    incline_rad: Floats
    slip_m_s: Floats
    incline_sigma_rad: Floats
    speed_sigma_m_s: Floats
    rounding: Whole
    rounding_sigma_rad: Floats
    rounding_draws: Floats
    weight_n: float
    zero_sigma_rad: Floats
    tracks: Tracks
    inertia_n: Floats
    inertia_sigma_n: Floats
    belt_sigma: float

    @classmethod
    def of(cls, session: Session) -> Stations:
        """Take a session's kept stations."""
        kept = session.kept
        belt, belt_sigma = session.belt_scale
        given, same = session.setup.instruments, np.ones(len(kept))
        bends, zero = Bends.of(session, kept), session.zero
        shown_rad = np.array([r.incline_rad for r in kept], dtype=float)
        tracks = _tracks(session)
        inertia_n, inertia_sigma_n = tracks.inertia()
        step = session.setup.instruments.incline_step_rad
        rounding, draws = shared_rounding(shown_rad, given.incline_sigma_rad, step)
        sigma_rad = draws.std(axis=0)
        return cls(
            numbers=np.array([r.number for r in kept], dtype=np.intp),
            bends=bends,
            incline_rad=shown_rad - zero.value_rad,
            slip_m_s=np.array([belt * r.belt_speed_m_s - r.drift_m_s for r in kept], dtype=float),
            incline_sigma_rad=np.where(rounding < 0, given.incline_sigma_rad, 0.0),
            speed_sigma_m_s=given.belt_speed_sigma_m_s * same,
            rounding=rounding,
            rounding_sigma_rad=sigma_rad,
            rounding_draws=draws / sigma_rad,
            weight_n=session.setup.weight_n,
            zero_sigma_rad=(zero.sigma_rad or ZERO_SIGMA_RAD) * same,
            tracks=tracks,
            inertia_n=inertia_n,
            inertia_sigma_n=inertia_sigma_n,
            belt_sigma=belt_sigma if session.on_floor else 0.0,
        )

    def __len__(self) -> int:
        return len(self.slip_m_s)

    @property
    def lambda_rad(self) -> Floats:
        """Return the bend of each reading, as set."""
        return self.bends.lambda_rad

    @property
    def bent(self) -> NDArray[np.bool_]:
        """Tell which readings were taken with the robot bent."""
        return self.bends.posture >= 0

    @property
    def parts(self) -> dict[str, NDArray[np.bool_]]:
        """Return which readings are straight, and bent."""
        return {"straight": ~self.bent, "bent": self.bent}

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return the frictions, then what readings share."""
        shared = ["zero", *(f"rounding {k}" for k in range(len(self.rounding_sigma_rad)))]
        shared += ["belt"] if self.belt_sigma > 0.0 else []
        frictions = (Unknown(name, friction=True) for name in FRICTIONS)
        bends = self.bends
        return (*frictions, *bends.unknowns, *map(Unknown, shared), *bends.straightness)

    def near(self, values: Values) -> Stations:
        """Return itself: nothing in it is made linear."""
        return self

    def residuals(self, values: Values) -> Floats:
        """Return r_i (K, N): see the head of this file."""
        return np.asarray(np.divide(*self._balance(values, self._rounding_rad(values))[:2]))

    def whole_residuals(self, values: Values) -> tuple[Floats, Floats]:
        """Return (K, N) residuals with the shared rounding in them, and s_i^2's share in theirs.

        The residual is over all that a reading may err by, alone and in common.
        """
        excess, spread, per_incline = self._balance(values, 0.0)
        whole = np.hypot(spread, per_incline * self.shared_sigma_rad)
        return excess / whole, (spread / whole) ** 2

    @property
    def shared_sigma_rad(self) -> Floats:
        """Return the standard deviation of each reading's shared rounding; 0 where it has none."""
        return np.append(self.rounding_sigma_rad, 0.0)[self.rounding]

    def _balance(self, values: Values, rounding_rad: Floats | float) -> tuple[Floats, ...]:
        """Return excess force, its standard deviation, and its slope by the incline, (K, N), N."""
        bends, angles = self.bends, self.bends.angles_rad(values)
        law = frictions_in(values), bends.share, angles, bends.astray_rad(values)
        viscous, dry = resistance(*law)
        incline = self.incline_rad - self.zero_sigma_rad * values["zero"][:, None] - rounding_rad
        weight_n, belt = self.weight_n, 1.0
        if self.belt_sigma > 0.0:
            belt = 1.0 + self.belt_sigma * values["belt"][:, None]
        slip = belt * self.slip_m_s * np.ones_like(viscous)
        per_incline_n = weight_n * np.cos(incline)
        drag_n = self.tracks.drag(viscous, slip)
        excess_n = weight_n * np.sin(incline) - drag_n - dry
        alone_n = np.hypot(per_incline_n * self.incline_sigma_rad, self.inertia_sigma_n)
        spread_n = np.hypot(alone_n, belt * viscous * self.speed_sigma_m_s)
        return excess_n, np.maximum(spread_n, _LEAST_N), per_incline_n

    def _rounding_rad(self, values: Values) -> Floats | float:
        """Return each reading's shared rounding error, (K, N)."""
        count = len(self.rounding_sigma_rad)
        if not count:
            return 0.0
        unit = np.stack([values[f"rounding {k}"] for k in range(count)], axis=1)
        errors = unit @ (self.rounding_sigma_rad[:, None] * self.rounding_root).T
        return np.column_stack([errors, np.zeros(len(errors))])[:, self.rounding]

    @cached_property
    def rounding_root(self) -> Floats:
        """Return the root of the shared rounding errors' correlation, (errors, errors)."""
        drawn = self.rounding_draws
        together = drawn.T @ drawn / max(len(drawn), 1)
        # less than a ten thousandth of it is a set point's alone, or many points had no inverse
        return np.linalg.cholesky(together + 1e-4 * np.eye(len(together)))

    @property
    def pool(self) -> tuple[tuple[str, ...], Floats]:
        """Return the roundings: sawteeth, which have no tails."""
        names = tuple(f"rounding {k}" for k in range(len(self.rounding_sigma_rad)))
        return names, np.linalg.solve(self.rounding_root, self.rounding_draws.T).T

    def nuisances(self, values: Values) -> dict[str, Floats]:
        """Return what is shared by the name that a fit gives it, in its unit."""
        zero = float(self.zero_sigma_rad.max()) * values["zero"]
        return self.bends.nuisances(values) | {"incline_zero_rad": zero}


def _tracks(session: Session) -> Tracks:
    setup, kept = session.setup, session.kept
    mass_kg = setup.robot.links * setup.robot.link_mass_kg
    return Tracks.of(
        [r.places for r in kept],
        [setup.instruments] * len(kept),
        mass_kg,
        rolling_share(setup.robot_table.wheels_kg, mass_kg),
    )
