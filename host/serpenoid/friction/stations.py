"""Residuals of stations on a belt, each a balance of forces, with the errors that they share.

A robot that holds its station at slip v has m g sin(gamma) = A v + B. The true speed of each
reading is eliminated in closed form (errors in variables), which leaves the residuals

    r_i = (m g sin(gamma_i - z) - A v_i - B) / s_i,
    s_i^2 = (m g cos(gamma_i - z) sg)^2 + (A sv)^2.

where sg and sv are the standard deviations of incline and speed. For a robot that still drifted,
-m_e f from its track replaces A v (`drift`), and s_i contains the track's error. Readings share the
bends' errors, the inclinometer's zero z, its rounding errors (`rounding`), the scale of the belt's
speed, and the angles of straight links to their path (`bends`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..session.session import Session
from .bends import Bends, frictions_in, resistance
from .parameters import (
    BELT,
    FRICTION_PARAMETERS,
    ROUNDING,
    ZERO,
    ZERO_SIGMA_RAD,
    Floats,
    Integers,
    Parameter,
    Values,
)
from .rounding import shared_rounding

if TYPE_CHECKING:
    from .drift import Drift


@dataclass(frozen=True, eq=False)
class Stations:
    """The kept stations of a session.

    For each of N readings, (N,): numbers; incline_rad as shown, less the zero if it was measured;
    slip_m_s, the belt's speed past the robot; incline_sigma_rad, of the errors that are not shared;
    rounding, index of the shared rounding error, -1 for none; inertia_n and inertia_sigma_n, force
    of inertia of a drifting robot and its sigma.

    speed_sigma_m_s: sigma of a speed. rounding_samples: samples of the shared rounding errors, rad,
    (samples, errors). drifts: index of a reading -> its drift. belt_sigma: relative sigma of the
    belt's scale if it is a parameter, with pushes beside the stations; else 0.
    """

    numbers: Integers
    bends: Bends
    incline_rad: Floats
    slip_m_s: Floats
    incline_sigma_rad: Floats
    speed_sigma_m_s: float
    rounding: Integers
    rounding_samples: Floats
    weight_n: float
    zero_sigma_rad: float
    drifts: dict[int, Drift]
    inertia_n: Floats
    inertia_sigma_n: Floats
    belt_sigma: float

    @classmethod
    def from_session(cls, session: Session) -> Stations:
        """Return the kept stations of a session."""
        instruments, zero = session.setup.instruments, session.zero
        kept_stations = session.kept_stations
        belt, belt_sigma = session.belt_scale
        shown_rad = np.array([r.incline_rad for r in kept_stations], dtype=float)
        rounding, samples = shared_rounding(
            shown_rad, instruments.incline_sigma_rad, instruments.incline_step_rad
        )
        drifts: dict[int, Drift] = {}
        if any(reading.track for reading in kept_stations):
            from .drift import drifts_of

            drifts = drifts_of(session)
        inertia_n, sigma_n = np.zeros((2, len(kept_stations)))
        for k, drift in drifts.items():
            inertia_n[k] = -drift.force_n(np.zeros(1))[0]
            sigma_n[k] = drift.force_sigma_n
        return cls(
            numbers=np.array([r.number for r in kept_stations], dtype=np.intp),
            bends=Bends.from_session(session, kept_stations),
            incline_rad=shown_rad - zero.value_rad,
            slip_m_s=np.array(
                [belt * r.belt_speed_m_s - r.drift_m_s for r in kept_stations], dtype=float
            ),
            incline_sigma_rad=np.where(rounding < 0, instruments.incline_sigma_rad, 0.0),
            speed_sigma_m_s=instruments.belt_speed_sigma_m_s,
            rounding=rounding,
            rounding_samples=samples,
            weight_n=session.setup.weight_n,
            zero_sigma_rad=zero.sigma_rad or ZERO_SIGMA_RAD,
            drifts=drifts,
            inertia_n=inertia_n,
            inertia_sigma_n=sigma_n,
            belt_sigma=belt_sigma if session.on_floor else 0.0,
        )

    on_belt = True
    slips = False  # Robots on a belt are steered.

    @property
    def fastest_m_s(self) -> float:
        """Return the largest slip speed, m/s."""
        return float(self.slip_m_s.max())

    def __len__(self) -> int:
        return len(self.slip_m_s)

    @property
    def lambda_rad(self) -> Floats:
        """Return the bend of each reading as set, rad, (N,)."""
        return self.bends.lambda_rad

    @property
    def bent(self) -> NDArray[np.bool_]:
        """Return whether each reading was taken with the robot bent, (N,)."""
        return self.bends.posture >= 0

    @property
    def parts(self) -> dict[str, NDArray[np.bool_]]:
        """Return masks (N,) of the straight and of the bent readings."""
        return {"straight": ~self.bent, "bent": self.bent}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Return the parameters: the frictions, then the errors that readings share."""
        belt = (Parameter(BELT, 1.0, self.belt_sigma),) if self.belt_sigma else ()
        roundings = [
            Parameter(f"{ROUNDING}{k}", sigma=sigma)
            for k, sigma in enumerate(self.rounding_samples.std(axis=0).tolist())
        ]
        zero = Parameter(ZERO, sigma=self.zero_sigma_rad)
        return (*FRICTION_PARAMETERS, zero, *belt, *self.bends.parameters, *roundings)

    def linear_about(self, values: Values) -> Stations:
        """Return the stations themselves, which need no linearisation."""
        return self

    def residuals(self, values: Values) -> Floats:
        """Return the residuals r_i (K, N) of parameter values (K,)."""
        count = self.rounding_samples.shape[1]
        errors = [values[f"{ROUNDING}{k}"] for k in range(count)]
        errors.append(np.zeros(1))  # Readings of index -1 share no error.
        shared = np.stack(np.broadcast_arrays(*errors), axis=1)[:, self.rounding]
        excess, spread, _ = self._balance(values, shared)
        return np.asarray(excess / spread)

    def sizes(self, values: Values) -> Floats:
        """Return residuals (N,) at values (1,), over sigmas that contain the shared rounding."""
        excess, spread, per_incline = self._balance(values, 0.0)
        return np.asarray(excess / np.hypot(spread, per_incline * self.shared_sigma_rad))[0]

    @property
    def shared_sigma_rad(self) -> Floats:
        """Return the sigma of each reading's shared rounding error, rad, (N,); 0 if it has none."""
        return np.append(self.rounding_samples.std(axis=0), 0.0)[self.rounding]

    def _balance(
        self, values: Values, rounding_rad: Floats | float
    ) -> tuple[Floats, Floats, Floats]:
        """Return excess force and its sigma, N, and its derivative by incline, N/rad, (K, N)."""
        bends, angles = self.bends, self.bends.angles_rad(values)
        law = frictions_in(values), bends.share, angles, bends.stray_angles_rad(values)
        viscous, dry = resistance(*law)
        incline = self.incline_rad - values[ZERO][:, None] - rounding_rad
        belt = values[BELT][:, None] if self.belt_sigma else 1.0
        drag_n = viscous * belt * self.slip_m_s
        for k, drift in self.drifts.items():
            drag_n[:, k] -= drift.force_n(viscous[:, k])
        per_incline_n = self.weight_n * np.cos(incline)
        excess_n = self.weight_n * np.sin(incline) - drag_n - dry
        spread_n = np.hypot(per_incline_n * self.incline_sigma_rad, self.inertia_sigma_n)
        spread_n = np.hypot(spread_n, belt * viscous * self.speed_sigma_m_s)
        return excess_n, np.maximum(spread_n, 1e-12), per_incline_n
