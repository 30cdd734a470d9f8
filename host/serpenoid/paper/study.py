"""The study of 2005 remade: its runs, sweep and optima; its claims beside what is found here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.vectors import Array
from ..gaits.least_power import LeastPower, power_front
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.presets import PRESETS
from ..model.robot import Robot
from ..periodic.steady import Steady, steady_gait
from ..periodic.sweep import Sweep, sweep
from ..simulation.run import Run
from ..simulation.scene import Scene
from ..simulation.simulate import simulate
from ..simulation.steady_springs import steady_springs

D = math.pi / 180  # One degree, rad.
(OF_2005, BINGHAM), (ROBOT, GROUND) = PRESETS.values()
PATH_GAIT, EXPERIMENT = Gait(30 * D, 80 * D, 5.0), Gait(70 * D, 75 * D, math.pi)


class Comparison(NamedTuple):
    """Errors of the implicit against the exact model in time, of the tail link of three, (T,).

    Their velocity's is the size of its error.
    """

    t_s: Array
    angle_rad: Array
    velocity_m_s: Array


def compare_formulations(gap: str) -> Comparison:
    """Run both formulations side by side (Figs. 6 and 7): RK4, 1 ms, link 1 at rest at first.

    gap: how the joints start, "zero" (closed, so that their springs ring; the paper's) or
    "slow_manifold" (open by their load).
    """
    three = Robot(3, 1.0, 0.12), GROUND, Gait(30 * D, 90 * D, 3.0)
    scene = Scene(*three, method="rk4", start="link1_at_rest", gap=gap, record_every=1)
    exact, soft = simulate(scene), simulate(replace(scene, formulation="implicit"))
    size = np.hypot(soft.vx_m_s - exact.vx_m_s, soft.vy_m_s - exact.vy_m_s)
    return Comparison(exact.t_s, (soft.theta_rad - exact.theta_rad)[:, 0], size[:, 0])


def papers_sweep() -> Sweep:
    """Solve the paper's 4500 gaits."""
    return sweep(
        ROBOT,
        GROUND,
        alpha_rad=np.arange(5, 76, 5) * D,
        beta_rad=np.arange(20, 91, 5) * D,
        omega_rad_s=np.arange(1.0, 21.0),
        powers=False,
    )


def optima(robot: Robot, ground: Ground, last_m_s: float) -> list[LeastPower]:
    """Find a robot's least-power gaits over the paper's speeds, up to the last one."""
    speeds_m_s = np.array([0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7])
    reachable_m_s = speeds_m_s[speeds_m_s <= last_m_s]
    return list(filter(None, power_front(robot, ground, speeds_m_s=reachable_m_s)))


def cloud_2005() -> Sweep:
    """Solve a grid of gaits of the 2005 robot on its measured, dry ground."""
    return sweep(
        OF_2005,
        BINGHAM,
        alpha_rad=np.arange(30, 106, 5) * D,
        beta_rad=np.arange(40, 111, 5) * D,
        omega_rad_s=np.geomspace(0.7, 12, 12),
        rtol=1e-3,
        powers=False,
    )


def path_run(gait: Gait, cycles: int) -> Run:
    """Return a run of the periodic state (Figs. 12 and 13)."""
    return simulate(
        Scene(
            ROBOT,
            GROUND,
            gait,
            start="steady",
            method="rk4",
            dt_s=gait.period_s / 600,
            record_every=5,
            duration_s=cycles * gait.period_s,
        )
    )


def dearer(front: Sequence[LeastPower], speed_m_s: float) -> float:
    """Return by what fraction the paper's (30, 80) deg costs more than the optimum at a speed."""
    from scipy.optimize import brentq

    best = min(front, key=lambda b: abs(b.speed_m_s - speed_m_s))

    def papers(rate: float) -> Steady:
        return steady_gait(ROBOT, GROUND, replace(PATH_GAIT, omega_rad_s=rate))

    around = 0.2 * best.gait.omega_rad_s, 5 * best.gait.omega_rad_s
    rate: Any = brentq(lambda rate: papers(rate).speed_m_s - best.speed_m_s, *around)
    return papers(rate).power_w / best.power_w - 1


def without_dry_friction_along() -> list[tuple[float, float, float]]:
    """Return frequency in Hz, and by what part speed and power change without ft0 (2005 robot)."""
    changes = []
    for frequency in (0.2, 0.5, 1.0, 1.5, 2.0):
        gait = replace(EXPERIMENT, omega_rad_s=2 * math.pi * frequency)
        full, free = (
            steady_gait(OF_2005, ground, gait, rtol=1e-4)
            for ground in (BINGHAM, replace(BINGHAM, ft0=0.0))
        )
        changes.append(
            (frequency, free.speed_m_s / full.speed_m_s - 1, free.power_w / full.power_w - 1)
        )
    return changes


class Claim(NamedTuple):
    """One claim: where, what the paper says, what is found here, the verdict.

    verdict: "agrees", "in part", "differs" or "not comparable".
    """

    where: str
    paper: str
    result: str
    verdict: str


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


def _formulations(closed: Comparison, opened: Comparison) -> list[Claim]:
    theta, smooth = (float(np.abs(run.angle_rad).max()) for run in (closed, opened))
    when = float(closed.t_s[np.abs(closed.angle_rad).argmax()])
    ringing_s, settled_s = 0.2, 8.0  # Times until which the springs ring, and from which they rest.
    early = float(closed.velocity_m_s[closed.t_s < ringing_s].max())
    settled = float(closed.velocity_m_s[closed.t_s > settled_s].max())
    gaits = [replace(PATH_GAIT, omega_rad_s=rate) for rate in (5.0, 10.0, 20.0)]
    errors = [steady_springs(ROBOT, GROUND, gait).modelling_error for gait in gaits]
    return [
        Claim(
            "Fig. 6",
            "error of the tail's angle of order 1e-3 rad",
            f"{theta:.1e} rad at most, at {when:.3g} s, while the springs ring, as all gaps are "
            f"closed at first; {smooth:.1e} rad from gaps opened by the forces they carry",
            _verdict_within(0.5, [math.log10(theta / 1e-3)]),
        ),
        Claim(
            "Fig. 7",
            "errors of the velocities as small",
            f"{settled:.1e} m/s once settled, but {early:.1e} m/s in the first 0.2 s: from closed "
            "gaps the joints' springs ring",
            _verdict_within(3e-3, [settled, early]),
        ),
        Claim(
            "the search",
            "k = 1000 N/m stands for a pinned joint",
            f"speed off by {_percents(errors)} at 5, 10, 20 rad/s: the joints' resonances lie "
            "inside the grid",
            _verdict_within(0.01, errors),
        ),
    ]


def _optima(front: Sequence[LeastPower]) -> list[Claim]:
    gaits = [best.gait for best in front]
    angles = np.degrees([(gait.alpha_rad, gait.beta_rad) for gait in gaits])
    alpha, beta = angles.T
    rate, speed = np.array([(best.gait.omega_rad_s, best.speed_m_s) for best in front]).T
    bend = float(np.ptp(rate / speed) / (rate / speed).mean())
    low, high = dearer(front, 0.1), dearer(front, 0.5)
    waves = 6 * beta / 360
    first, last = np.array([[5, 20], [75, 90]])  # amplitude and lag at the ends of the paper's grid
    inside = np.all([first < angles, angles < last], axis=(0, 2))
    near_deg = 4.0  # Error of an angle that was read in the paper, to a step of its grid or so.
    near_waves = 0.05 + 6 * near_deg / 360  # Error of 1.3 waves, which may be rounded, and so read.
    flat_share = 0.05
    flat = ": the valley is flat" if max(low, high) < flat_share else ""
    return [
        Claim(
            "Fig. 8",
            "for each speed one gait costs least",
            f"so it does, its shape inside the grid at {sum(inside)} of {len(inside)} speeds",
            _verdict(inside),
        ),
        Claim(
            "Fig. 9",
            "the optimum's rate is nearly linear in speed",
            f"rate over speed varies by {100 * bend:.0f} % from {speed[0]:g} to {speed[-1]:g} m/s",
            _verdict_within(0.3, [bend]),
        ),
        Claim(
            "Fig. 10",
            "beta is 80 deg at every speed",
            f"{min(beta):.1f} to {max(beta):.1f} deg; (30, 80) deg costs {100 * low:.1f} % more "
            f"at 0.1 m/s and {100 * high:.1f} % at 0.5{flat}",
            _verdict_within(near_deg, beta - 80),
        ),
        Claim(
            "Fig. 11",
            "alpha is 30 deg at every speed",
            f"{alpha[2]:.1f} deg at {speed[2]:g} m/s, {alpha[-1]:.1f} at {speed[-1]:g}",
            _verdict_within(near_deg, alpha - 30),
        ),
        Claim(
            "text",
            "1.3 waves on the body",
            f"{min(waves):.2f} to {max(waves):.2f}",
            _verdict_within(near_waves, waves - 1.3),
        ),
    ]


def _verdict(parts: Sequence[Any] | NDArray[Any]) -> str:
    """Return the verdict on a claim by which parts of it hold."""
    return "agrees" if all(parts) else "in part" if any(parts) else "differs"


def _verdict_within(limit: float, errors: Sequence[float] | Array) -> str:
    return _verdict([abs(error) < limit for error in errors])


def _percents(shares: Sequence[float]) -> str:
    return ", ".join(f"{100 * share:+.0f} %" for share in shares)


def _experiment(bands: Sequence[tuple[float, float, float]]) -> list[Claim]:
    speed = steady_gait(OF_2005, BINGHAM, EXPERIMENT, rtol=1e-4).speed_m_s
    frequencies, speeds, powers = zip(*without_dry_friction_along(), strict=True)
    hertz, low, high = np.array([bands[0], bands[-1]]).T
    wide, part = high - low, 100 * (high - low) / (high + low)
    grows = wide[1] > wide[0], part[1] > part[0]
    return [
        Claim(
            "Figs. 15, 16",
            "friction is a line with an offset, Eqs. 59 and 62",
            "the lines are given back from readings made of them; the paper's points are lost",
            "not comparable",
        ),
        Claim(
            "Fig. 17",
            "predicted and measured speeds match",
            f"{speed:.3f} m/s predicted at 0.5 Hz; the paper's points are lost",
            "not comparable",
        ),
        Claim(
            "Fig. 17",
            "doubt about the normal friction is amplified at higher frequencies",
            f"the band of speeds is {wide[0]:.3f} m/s wide at {hertz[0]:g} Hz, {wide[1]:.3f} at "
            f"{hertz[1]:g}; of the speed that is ±{part[0]:.0f} % and ±{part[1]:.0f} %: "
            f"{'high' if grows[1] else 'low'} frequencies suffer most",
            _verdict(grows),
        ),
        Claim(
            "outlook",
            "static friction along the links matters little",
            f"without it the speed changes by {_percents(speeds)}, and the power by "
            f"{_percents(powers)}, at {frequencies} Hz",
            _verdict_within(0.05, [*speeds, *powers]),
        ),
    ]
