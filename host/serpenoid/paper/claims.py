"""The claims of the 2005 paper, one by one, beside what is found here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..gaits.least_power import LeastPower
from ..model.gait import Gait
from ..periodic.steady import steady_gait
from ..simulation.steady_springs import steady_springs
from .study import (
    BINGHAM,
    EXPERIMENT,
    GRID_ALPHA,
    GRID_BETA,
    GROUND,
    OF_2005,
    PATH_GAIT,
    ROBOT,
    Comparison,
    compare_torque_driven,
    dearer,
    finer_step,
    without_dry_friction_along,
)

_NEAR_DEG = 4.0  # an angle of the paper, read to a step of its grid or so
_NEAR_WAVES = 0.05 + 6 * _NEAR_DEG / 360  # 1.3 may be rounded, and so read
_FLAT = 0.05  # largest share of the power that counts as flat
RINGING_S, SETTLED_S = 0.2, 8.0  # until and from when the springs of Figs. 6 and 7 ring, and rest


@dataclass(frozen=True, slots=True)
class Claim:
    """Hold one claim: where, what the paper says, what is found here, the verdict, how to see it.

    verdict: "agrees", "in part", "differs" or "not comparable".
    """

    where: str
    paper: str
    result: str
    verdict: str
    command: str


def claims(
    closed: Comparison,
    opened: Comparison,
    front: Sequence[LeastPower],
    bands: Sequence[tuple[float, float, float]],
) -> list[Claim]:
    """Set the paper's claims beside what is found here.

    closed, opened: runs by the joints' gaps. bands: frequency in Hz, lowest and highest speed in
    m/s that the readings leave open, of the 2005 robot.
    """
    return [*_formulations(closed, opened), *_optima(front), *_experiment(bands)]


def _formulations(c: Comparison, opened: Comparison) -> list[Claim]:
    theta, smooth = (float(np.abs(run.theta_error_rad).max()) for run in (c, opened))
    when = float(c.t_s[np.abs(c.theta_error_rad).argmax()])
    size = np.hypot(*c.velocity_error_m_s.T)
    early = float(size[c.t_s < RINGING_S].max())
    settled = float(size[c.t_s > SETTLED_S].max())
    torque, finer = compare_torque_driven(), finer_step()
    errors = [
        steady_springs(ROBOT, GROUND, replace(PATH_GAIT, omega_rad_s=w)).modelling_error
        for w in (5.0, 10.0, 20.0)
    ]
    steady = "steady --robot paper --alpha-deg 30 --beta-deg 80 --omega-rad-s 20"
    return [
        Claim(
            "Fig. 6",
            "error of the tail's angle of order 1e-3 rad",
            f"{theta:.1e} rad at most, at {when:.3g} s, while the springs ring, as all gaps are "
            f"closed at first; {smooth:.1e} rad from gaps opened by the forces they carry",
            _verdict([abs(math.log10(theta / 1e-3))], 0.5),
            "figures (fig6-7.png)",
        ),
        Claim(
            "Fig. 7",
            "errors of the velocities as small",
            f"{settled:.1e} m/s once settled, but {early:.1e} m/s in the first 0.2 s: from closed "
            "gaps the joints' springs ring",
            _verdict([settled / 1e-3, early / 1e-3], 3.0),
            "figures (fig6-7.png)",
        ),
        Claim(
            "text",
            "a step below 1 ms changes displacements and velocities by at most 0.1 %",
            f"a quarter of it changes them by {100 * finer:.1g} % at most, by RK4",
            _verdict([finer], 1e-3),
            "simulate --robot paper --set links=3 --alpha-deg 30 --beta-deg 90 --omega-rad-s 3 "
            "--formulation implicit --method rk4 --set dt_s=0.00025",
        ),
        Claim(
            "Figs. 6, 7",
            "both formulations are mathematically equivalent",
            f"driven by one list of torques they part by {torque:.2g} rad in 10 s",
            _verdict([torque / 3e-3], 1.0),
            "figures (claims.json)",
        ),
        Claim(
            "the search",
            "k = 1000 N/m stands for a pinned joint",
            "speed off by "
            + ", ".join(f"{100 * e:+.0f} %" for e in errors)
            + " at 5, 10, 20 rad/s: the joints' resonances lie inside the grid",
            _verdict([abs(e) for e in errors], 0.01),
            f"{steady} --formulation implicit",
        ),
    ]


def _optima(front: Sequence[LeastPower]) -> list[Claim]:
    alpha = [math.degrees(b.gait.alpha_rad) for b in front]
    beta = [math.degrees(b.gait.beta_rad) for b in front]
    rate = np.array([b.gait.omega_rad_s for b in front])
    speed = np.array([b.speed_m_s for b in front])
    bend = np.ptp(rate / speed) / (rate / speed).mean()
    low, high = dearer(front, 0.1), dearer(front, 0.5)
    waves = [6 * b / 360 for b in beta]
    command = "optimize --robot paper --speed-m-s 0.5 --servo ideal --ideal"
    inside = [_inside_grid(best.gait) for best in front]
    flat = ": the valley is flat" if max(low, high) < _FLAT else ""
    return [
        Claim(
            "Fig. 8",
            "for each speed one gait costs least",
            f"so it does, its shape inside the grid at {sum(inside)} of {len(inside)} speeds",
            _joint_verdict(inside),
            command,
        ),
        Claim(
            "Fig. 9",
            "the optimum's rate is nearly linear in speed",
            f"rate over speed varies by {100 * bend:.0f} % from {speed[0]:g} to {speed[-1]:g} m/s",
            _verdict([bend], 0.3),
            command,
        ),
        Claim(
            "Fig. 10",
            "beta is 80 deg at every speed",
            f"{min(beta):.1f} to {max(beta):.1f} deg; (30, 80) deg costs {100 * low:.1f} % more "
            f"at 0.1 m/s and {100 * high:.1f} % at 0.5{flat}",
            _verdict([abs(b - 80) for b in beta], _NEAR_DEG),
            command,
        ),
        Claim(
            "Fig. 11",
            "alpha is 30 deg at every speed",
            f"{alpha[2]:.1f} deg at {speed[2]:g} m/s, {alpha[-1]:.1f} at {speed[-1]:g}",
            _verdict([abs(a - 30) for a in alpha], _NEAR_DEG),
            command,
        ),
        Claim(
            "text",
            "1.3 waves on the body",
            f"{min(waves):.2f} to {max(waves):.2f}",
            _verdict([abs(w - 1.3) for w in waves], _NEAR_WAVES),
            command,
        ),
    ]


def _verdict(errors: Sequence[float], allowed: float) -> str:
    """Return the verdict on a claim by its errors in several places."""
    return _joint_verdict([part < allowed for part in errors])


def _joint_verdict(parts: Sequence[bool]) -> str:
    """Return the verdict on a claim by which parts of it hold."""
    return "agrees" if all(parts) else "in part" if any(parts) else "differs"


def _inside_grid(gait: Gait) -> bool:
    """Tell whether a shape lies between the ends of the paper's grid."""
    (low, high), (short, long) = GRID_ALPHA, GRID_BETA
    return low < gait.alpha_rad < high and short < gait.beta_rad < long


def _experiment(bands: Sequence[tuple[float, float, float]]) -> list[Claim]:
    speed = steady_gait(OF_2005, BINGHAM, EXPERIMENT, rtol=1e-4).speed_m_s
    free = without_dry_friction_along()
    (slow, *_), (fast, *_) = bands[0], bands[-1]
    wide = [high - low for _, low, high in (bands[0], bands[-1])]
    part = [100 * (high - low) / (high + low) for _, low, high in (bands[0], bands[-1])]
    grows = wide[1] > wide[0], part[1] > part[0]
    command = "steady --robot 2005 --alpha-deg 70 --beta-deg 75 --frequency-hz"
    return [
        Claim(
            "Figs. 15, 16",
            "friction is a line with an offset, Eqs. 59 and 62",
            "the lines are given back from readings made of them; the paper's points are lost",
            "not comparable",
            "demo",
        ),
        Claim(
            "Fig. 17",
            "predicted and measured speeds match",
            f"{speed:.3f} m/s predicted at 0.5 Hz; the paper's points are lost",
            "not comparable",
            f"{command} 0.5",
        ),
        Claim(
            "Fig. 17",
            "doubt about the normal friction is amplified at higher frequencies",
            f"the band of speeds is {wide[0]:.3f} m/s wide at {slow:g} Hz, {wide[1]:.3f} at "
            f"{fast:g}; of the speed that is ±{part[0]:.0f} % and ±{part[1]:.0f} %: "
            f"{'high' if grows[1] else 'low'} frequencies suffer most",
            _joint_verdict(grows),
            "demo",
        ),
        Claim(
            "outlook",
            "static friction along the links matters little",
            "without it the speed rises by "
            + ", ".join(f"{100 * v:.0f} %" for _, v, _ in free)
            + " at "
            + ", ".join(f"{f:g}" for f, _, _ in free)
            + " Hz, and the power falls by "
            f"{-100 * max(p for *_, p in free):.0f} to {-100 * min(p for *_, p in free):.0f} %",
            _verdict([max(abs(v), abs(p)) for _, v, p in free], 0.05),
            f"{command} 1 --set ft0=0",
        ),
    ]


def as_dict(judged: Sequence[Claim]) -> dict[str, Any]:
    """Return the claims as plain values."""
    return {"claims": [asdict(claim) for claim in judged]}
