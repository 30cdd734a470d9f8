"""The study of 2005 remade: its runs, its sweep, its optima, and its claims one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.drives import TorqueTable
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import steady_gait
from ..periodic.sweep import Sweep, sweep
from ..simulation.run import Run
from ..simulation.scene import Scene
from ..simulation.simulate import simulate
from ..simulation.steady_springs import steady_springs
from .finder import LeastPower
from .least_power import power_front
from .robust import RobustGait, robust_gait
from .shapes import shape_of

Array = NDArray[np.float64]
D = math.pi / 180
ROBOT, GROUND = Robot(6, 1.0, 0.12), Ground(0.1, 10.0)
THREE = Robot(3, 1.0, 0.12)
THREE_GAIT = Gait(30 * D, 90 * D, 3.0)
OF_2005, BINGHAM = Robot(6, 0.0756, 0.076), Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)
PATH_GAIT, EXPERIMENT = Gait(30 * D, 80 * D, 5.0), Gait(70 * D, 75 * D, math.pi)
PAPERS_OPTIMUM = (30 * D, 80 * D)
FRONT_M_S = (0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7)
ROBUST_M_S = (0.05, 0.2, 0.4, 0.7)
FRONT_2005_M_S = (0.03, 0.05, 0.1, 0.15, 0.2)
GRID_ALPHA, GRID_BETA = (5 * D, 75 * D), (20 * D, 90 * D)
_NEAR_DEG = 4.0  # an angle of the paper, read to a step of its grid or so
_NEAR_WAVES = 0.05 + 6 * _NEAR_DEG / 360  # 1.3 may be rounded, and so read
_FLAT = 0.05  # of the power
COSTS = {"net": "power", "abs": "abs_power", "positive": "positive_power"}


@dataclass(frozen=True, slots=True)
class Reading:
    """Say how the paper is read where its words leave it open.

    power: "net" (mean of P), "abs" (of |P|) or "positive" (of P+). angles: what Eq. 57 drives,
    "joint" angles or "absolute" ones of the links. speed_along: "mean" direction of travel, or
    the global "x" of a start with link 1 along x and at rest.
    """

    power: str = "net"
    angles: str = "joint"
    speed_along: str = "mean"


@dataclass(frozen=True, slots=True)
class Claim:
    """Hold one claim: where, what the paper says, what is found here, the verdict, how to see it.

    verdict: "agrees", "in part", "differs" or "not comparable".
    """

    where: str
    paper: str
    here: str
    verdict: str
    command: str


@dataclass(frozen=True, slots=True)
class Comparison:
    """Hold the error of the implicit against the exact model in time, tail link of three.

    t_s (T,), theta_error_rad (T,), velocity_error_m_s (T, 2). gap: how the joints start, "zero"
    (closed, so that their springs ring; the paper's) or "slow_manifold" (open by their load).
    """

    gap: str

    t_s: Array
    theta_error_rad: Array
    velocity_error_m_s: Array


def compare_formulations(gap: str = "zero") -> Comparison:
    """Run both formulations side by side (Figs. 6 and 7): RK4, 1 ms, link 1 at rest at first."""
    scene = Scene(
        THREE,
        GROUND,
        THREE_GAIT,
        method="rk4",
        dt_s=1e-3,
        duration_s=10.0,
        record_every=1,
        start="link1_at_rest",
        gap=gap,
    )
    exact, soft = simulate(scene), simulate(replace(scene, formulation="implicit"))
    error = np.stack([soft.vx_m_s - exact.vx_m_s, soft.vy_m_s - exact.vy_m_s], axis=2)[:, 0]
    return Comparison(gap, exact.t_s, (soft.theta_rad - exact.theta_rad)[:, 0], error)


def compare_torque_driven() -> float:
    """Return the largest error of the tail's angle when both are driven by one list of torques."""
    scene = Scene(
        THREE,
        GROUND,
        THREE_GAIT,
        method="rk4",
        dt_s=1e-3,
        duration_s=10.0,
        record_every=1,
        record=("joints",),
    )
    run = simulate(scene)
    table = TorqueTable(run.t_s, run.joint_torque_nm)
    driven = replace(scene, drive="torque", torque=table, record=(), start=run.state(0))
    exact, soft = simulate(driven), simulate(replace(driven, formulation="implicit"))
    return float(np.abs(soft.theta_rad - exact.theta_rad).max())


def papers_sweep(powers: bool) -> Sweep:
    """Solve the paper's 4500 gaits."""
    return sweep(
        ROBOT,
        GROUND,
        alpha_rad=np.arange(5, 76, 5) * D,
        beta_rad=np.arange(20, 91, 5) * D,
        omega_rad_s=np.arange(1.0, 21.0),
        powers=powers,
    )


def papers_front(reading: Reading) -> list[LeastPower]:
    """Find the least-power gaits of the paper's robot over its speeds."""
    found = power_front(ROBOT, GROUND, speeds_m_s=np.array(FRONT_M_S), cost=COSTS[reading.power])
    return [best for best in found if best is not None]


def shown_amplitude_deg(gait: Gait, reading: Reading) -> float:
    """Return the amplitude as the reading counts it, of joints or of links."""
    if reading.angles == "joint":
        return math.degrees(gait.alpha_rad)
    return math.degrees(math.exp(shape_of(gait.alpha_rad, gait.beta_rad)[0]))


def along_x(gait: Gait) -> float:
    """Return speed along global x over speed along the way, from link 1 along x and at rest."""
    settled, cycles = steady_gait(ROBOT, GROUND, gait, powers=False), 15
    start = math.ceil(8 * settled.settling_time_s / gait.period_s)
    run = simulate(
        Scene(
            ROBOT,
            GROUND,
            gait,
            method="rk4",
            dt_s=gait.period_s / 400,
            record_every=400,
            duration_s=(start + cycles) * gait.period_s,
        )
    )
    x, y = run.x_m.mean(axis=1)[[start, -1]], run.y_m.mean(axis=1)[[start, -1]]
    return abs(x[1] - x[0]) / math.hypot(x[1] - x[0], y[1] - y[0])


def robust_front(
    robot: Robot, ground: Ground, speeds: Sequence[float], cost: str, samples: int
) -> list[RobustGait]:
    """Find the robust gaits over some speeds, by fewer samples than one alone would get."""
    return [
        robust_gait(robot, ground, speed_m_s=speed, cost=cost, samples=samples) for speed in speeds
    ]


def cloud_2005(powers: bool) -> Sweep:
    """Solve a grid of gaits of the 2005 robot on its measured, dry ground."""
    return sweep(
        OF_2005,
        BINGHAM,
        alpha_rad=np.arange(30, 106, 5) * D,
        beta_rad=np.arange(40, 111, 5) * D,
        omega_rad_s=np.geomspace(0.7, 12, 12),
        rtol=1e-3,
        powers=powers,
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


def dearer(front: Sequence[LeastPower], speed_m_s: float, cost: str) -> float:
    """Return by what fraction the paper's (30, 80) deg costs more than the optimum at a speed."""
    best = min(front, key=lambda b: abs(b.speed_m_s - speed_m_s))
    low, high = 0.2 * best.gait.omega_rad_s, 5 * best.gait.omega_rad_s
    for _ in range(50):
        rate = math.sqrt(low * high)
        slow = steady_gait(ROBOT, GROUND, Gait(*PAPERS_OPTIMUM, rate)).speed_m_s < best.speed_m_s
        low, high = (rate, high) if slow else (low, rate)
    state = steady_gait(ROBOT, GROUND, Gait(*PAPERS_OPTIMUM, high))
    return float(getattr(state, f"{cost}_w")) / best.power_w - 1


def claims(
    closed: Comparison,
    opened: Comparison,
    front: Sequence[LeastPower],
    reading: Reading,
    bands: Sequence[tuple[float, float, float]],
) -> list[Claim]:
    """Set the paper's claims beside what is found here.

    closed, opened: runs by the joints' gaps. bands: frequency in Hz, lowest and highest speed in
    m/s that the readings leave open, of the 2005 robot.
    """
    return [*_formulations(closed, opened), *_optima(front, reading), *_experiment(bands)]


def finer_step(dt_s: float = 2.5e-4) -> float:
    """Return by what part of the largest value a shorter step than 1 ms changes places and speeds.

    Of the paper's three links, by both formulations.
    """
    worst = 0.0
    for formulation in ("explicit", "implicit"):
        scene = Scene(
            THREE,
            GROUND,
            THREE_GAIT,
            formulation=formulation,
            method="rk4",
            dt_s=1e-3,
            duration_s=10.0,
            record_every=10,
            start="link1_at_rest",
        )
        run = simulate(scene)
        fine = simulate(replace(scene, dt_s=dt_s, record_every=round(1e-2 / dt_s)))
        for x, y in (("x_m", "y_m"), ("vx_m_s", "vy_m_s")):
            full = np.hypot(getattr(run, x), getattr(run, y)).max()
            off = np.hypot(getattr(run, x) - getattr(fine, x), getattr(run, y) - getattr(fine, y))
            worst = max(worst, float(off.max() / full))
    return worst


def without_dry_friction_along() -> list[tuple[float, float, float]]:
    """Return frequency in Hz, and by what part speed and power change without ft0 (2005 robot)."""
    found = []
    for frequency in (0.2, 0.5, 1.0, 1.5, 2.0):
        gait = replace(EXPERIMENT, omega_rad_s=2 * math.pi * frequency)
        full, free = (
            steady_gait(OF_2005, ground, gait, rtol=1e-4)
            for ground in (BINGHAM, replace(BINGHAM, ft0=0.0))
        )
        found.append(
            (frequency, free.speed_m_s / full.speed_m_s - 1, free.power_w / full.power_w - 1)
        )
    return found


def _formulations(c: Comparison, opened: Comparison) -> list[Claim]:
    theta, smooth = (float(np.abs(run.theta_error_rad).max()) for run in (c, opened))
    when = float(c.t_s[np.abs(c.theta_error_rad).argmax()])
    size = np.hypot(*c.velocity_error_m_s.T)
    early, late = float(size[c.t_s < 0.2].max()), float(size[c.t_s > 8].max())
    torque, finer = compare_torque_driven(), finer_step()
    off = [
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
            "figures (fig6-7.csv)",
        ),
        Claim(
            "Fig. 7",
            "errors of the velocities as small",
            f"{late:.1e} m/s once settled, but {early:.1e} m/s in the first 0.2 s: from closed "
            "gaps the joints' springs ring",
            _verdict([late / 1e-3, early / 1e-3], 3.0),
            "figures (fig6-7.csv)",
        ),
        Claim(
            "text",
            "a step below 1 ms changes displacements and velocities by at most 0.1 %",
            f"a quarter of it changes them by {100 * finer:.1g} % at most, by RK4",
            _verdict([finer], 1e-3),
            "simulate --robot paper --links 3 --alpha-deg 30 --beta-deg 90 --omega-rad-s 3 "
            "--formulation implicit --method rk4 --dt-s 0.00025",
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
            + ", ".join(f"{100 * e:+.0f} %" for e in off)
            + " at 5, 10, 20 rad/s: the joints' resonances lie inside the grid",
            _verdict([abs(e) for e in off], 0.01),
            f"{steady} --formulation implicit",
        ),
    ]


def _optima(front: Sequence[LeastPower], reading: Reading) -> list[Claim]:
    cost = COSTS[reading.power]
    alpha = [shown_amplitude_deg(b.gait, reading) for b in front]
    beta = [math.degrees(b.gait.beta_rad) for b in front]
    rate = np.array([b.gait.omega_rad_s for b in front])
    speed = np.array([b.speed_m_s for b in front])
    bend = np.ptp(rate / speed) / (rate / speed).mean()
    low, high = dearer(front, 0.1, cost), dearer(front, 0.5, cost)
    waves = [6 * b / 360 for b in beta]
    command = f"optimize --robot paper --speed-m-s 0.1,0.5 --cost {cost}"
    inside = [_inside_grid(best.gait) for best in front]
    alone = [best.runner_up_w > best.power_w for best in front]
    so = "so it does" if all(alone) else f"so it does at {sum(alone)} of {len(alone)} speeds"
    second = min(best.runner_up_w / best.power_w - 1 for best in front)
    told = f"other valleys of shapes cost {100 * second:.2g} % more at least"
    flat = ": the valley is flat" if max(low, high) < _FLAT else ""
    return [
        Claim(
            "Fig. 8",
            "for each speed one gait costs least",
            f"{so}, its shape inside the grid at {sum(inside)} of {len(inside)} speeds; "
            + (told if second < math.inf else "no other valley of shapes was found"),
            _held([a and b for a, b in zip(inside, alone, strict=True)]),
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


def _verdict(off: Sequence[float], allowed: float) -> str:
    """Return the verdict on a claim by how far off it is, here and there."""
    return _held([part < allowed for part in off])


def _held(parts: Sequence[bool]) -> str:
    """Return the verdict on a claim by which parts of it hold."""
    return "agrees" if all(parts) else "in part" if any(parts) else "differs"


def _inside_grid(gait: Gait) -> bool:
    """Tell whether a shape lies between the ends of the paper's grid."""
    (low, high), (least, most) = GRID_ALPHA, GRID_BETA
    return low < gait.alpha_rad < high and least < gait.beta_rad < most


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
            _held(grows),
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
            f"{command} 1 --ft0 0",
        ),
    ]


def as_dict(found: Sequence[Claim], reading: Reading) -> dict[str, Any]:
    """Return claims and reading as plain values."""
    return {
        "reading": {name: getattr(reading, name) for name in reading.__slots__},
        "claims": [{name: getattr(c, name) for name in c.__slots__} for c in found],
    }
