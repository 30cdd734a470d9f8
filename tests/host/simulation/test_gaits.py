"""RK4 on the implicit model with imposed angles, held to NumPy and to itself."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from serpenoid.model.link_state import LinkState
from serpenoid.simulation.stability import joint_modes
from serpenoid.simulation.starts import start_state

LINK_FIELDS = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s")
GAIT = sn.Gait(math.radians(30), math.radians(80), 5.0)
TILT: dict[str, Any] = {"incline_rad": 0.3, "incline_direction_rad": 2.0}
GROUNDS = {
    "viscous": (sn.Ground(0.1, 10.0), 0.0),
    "dry": (sn.Ground(0.1, 10.0, 0.02, 0.05), 0.0),
    "smoothed": (sn.Ground(0.1, 10.0, 0.02, 0.05), 1e-2),
    "ratchet": (sn.Ground((0.1, 0.7), 10.0, (0.02, 0.3), 0.05), 0.0),
    "smoothed ratchet": (sn.Ground((0.1, 0.7), 10.0, (0.02, 0.3), 0.05), 1e-2),
}


def scene_of(links: int, ground: str = "viscous", **changes: object) -> sn.Scene:
    law, width = GROUNDS[ground]
    fields = {
        "formulation": "implicit",
        "duration_s": 0.3,
        "smoothing_m_s": width,
        "gait": GAIT,
        "start": "link1_at_rest",
        "method": "rk4",
        **changes,
    }
    return sn.Scene(sn.Robot(links, 1.0, 0.12), law, **fields)  # type: ignore[arg-type]


def packed(state: LinkState) -> np.ndarray:
    """Return x, y, vx, vy of all links, then theta and omega of link 1, (4 n + 2,)."""
    tail = [state.theta_rad[0], state.omega_rad_s[0]]
    return np.concatenate([state.x_m, state.y_m, state.vx_m_s, state.vy_m_s, tail])


def moved(
    state: LinkState, heading_rad: float = 0.0, faster_m_s: float | np.ndarray = 0.0
) -> LinkState:
    """Return a state whose links' angles and velocities along x are changed."""
    return replace(state, theta_rad=state.theta_rad + heading_rad, vx_m_s=state.vx_m_s + faster_m_s)


def end_of(scene: sn.Scene, start: LinkState) -> np.ndarray:
    """Run from a start; return the end, (4 n + 2,)."""
    run = sn.simulate(replace(scene, start=start))
    return packed(LinkState(*(getattr(run, name)[-1] for name in LINK_FIELDS)))


def numpy_rate(scene: sn.Scene, gait: sn.Gait, t: float, y: np.ndarray) -> np.ndarray:
    """Return y' link by link from Eqs. 28-33 and 51-57, in the plainest way."""
    n, m, half = scene.robot.links, scene.robot.link_mass_kg, scene.robot.link_length_m / 2
    inertia, g, w = scene.robot.inertia_kg_m2, scene.ground, gait.omega_rad_s
    place, speed = y[: 2 * n].reshape(2, n).T, y[2 * n : 4 * n].reshape(2, n).T
    phase = w * t + gait.beta_rad * np.arange(n - 1)
    bends = gait.offset_rad + gait.alpha_rad * np.sin(phase)
    theta = y[4 * n] + np.concatenate([[0], np.cumsum(bends)])
    omega = y[4 * n + 1] + np.concatenate([[0], np.cumsum(w * gait.alpha_rad * np.cos(phase))])
    turn = np.concatenate([[0], np.cumsum(-w * w * gait.alpha_rad * np.sin(phase))])
    along = np.stack([np.cos(theta), np.sin(theta)], axis=1)
    across = np.stack([-np.sin(theta), np.cos(theta)], axis=1)

    def drag(v, c, dry, c_back, dry_back):
        width = scene.smoothing_m_s
        sign = v / np.sqrt(v**2 + width**2) if width > 0 else np.sign(v)
        c, dry = ((f + b) / 2 + (f - b) / 2 * sign for f, b in ((c, c_back), (dry, dry_back)))
        return -c * v - dry * sign

    ways = g.ct_forward, g.ft0_forward, g.ct_backward, g.ft0_backward
    force = drag((speed * along).sum(1), *ways)[:, None] * along
    force += drag((speed * across).sum(1), g.cn, g.fn0, g.cn, g.fn0)[:, None] * across
    arm, arm_rate = half * along, half * omega[:, None] * across
    gap = (place - arm)[1:] - (place + arm)[:-1]
    gap_rate = (speed - arm_rate)[1:] - (speed + arm_rate)[:-1]
    joint = np.zeros((n + 1, 2))
    joint[1:-1] = scene.joint_stiffness_n_m * gap + scene.joint_damping_n_s_m * gap_rate
    couple = (half * across * (joint[1:] + joint[:-1])).sum()
    pull = -9.80665 * math.sin(scene.incline_rad)
    uphill = scene.incline_direction_rad
    weight = pull * np.array([math.cos(uphill), math.sin(uphill)])
    accelerations = (force + joint[1:] - joint[:-1]) / m + weight
    spin = (couple - inertia * turn.sum()) / (n * inertia)
    return np.concatenate([y[2 * n : 4 * n], *accelerations.T, [y[4 * n + 1], spin]])


def numpy_rk4(scene, gait, y, dt, steps):
    for i in range(steps):
        t = i * dt
        k1 = numpy_rate(scene, gait, t, y)
        k2 = numpy_rate(scene, gait, t + dt / 2, y + dt / 2 * k1)
        k3 = numpy_rate(scene, gait, t + dt / 2, y + dt / 2 * k2)
        k4 = numpy_rate(scene, gait, t + dt, y + dt * k3)
        y = y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return y


def off(found: np.ndarray, exact: np.ndarray) -> float:
    """Return the largest difference, as a part of the largest value of its kind."""
    n = (exact.size - 2) // 4
    parts = [slice(0, 2 * n), slice(2 * n, 4 * n), slice(4 * n, 4 * n + 1), slice(4 * n + 1, None)]
    return max(np.abs(found[p] - exact[p]).max() / (1 + np.abs(exact[p]).max()) for p in parts)


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("tilt", [{}, TILT], ids=["level", "tilted"])
@pytest.mark.parametrize("links", [2, 5, 8])
def test_runs_agree_with_numpy(links: int, ground: str, tilt: dict[str, Any]) -> None:
    """200 steps: a few hundred roundings of 1e-16, which the springs pass on but do not grow."""
    gaits = [GAIT, sn.Gait(math.radians(170), 0.3, 7.0, -0.4), sn.Gait(0.0, 0.0, 1.0)]
    headings = [0.3, -40.0, 2e6]  # two far from 0
    for gait, heading in zip(gaits, headings, strict=True):
        scene = scene_of(links, ground, duration_s=0.2, gait=gait, gap="zero", **tilt)
        start = moved(start_state(scene), heading, 0.1)
        exact = numpy_rk4(scene, gait, packed(start), scene.dt_s, 200)
        assert off(end_of(scene, start), exact) < 3e-12


def many_gaits(count: int) -> list[sn.Gait]:
    rng = np.random.default_rng(5)
    return [
        sn.Gait(*rng.uniform([0.1, 0.3, 1.0, -0.3], [1.3, 2.0, 12.0, 0.3])) for _ in range(count)
    ]


@pytest.mark.parametrize("links", [2, 3, 6, 20])
def test_no_shape_has_faster_springs_than_the_bound(links: int) -> None:
    """What spares the modes of every gait must hold for each, and be near."""
    for gait in [sn.Gait(0.0, 0.0, 1.0), *many_gaits(10)]:
        scene = replace(scene_of(links), gait=gait)
        for one in (scene, replace(scene, drive="torque", torque=[0.0] * (links - 1))):
            exact, bound = joint_modes(one), joint_modes(one, any_shape=True)
            assert bound[0] >= exact[0] > 0.25 * bound[0]
            assert bound[1] <= exact[1]


def test_what_is_recorded_changes_no_bit() -> None:
    scene = scene_of(6, duration_s=0.1003, record_every=1)
    fine = sn.simulate(replace(scene, record=("joints",)))
    rough = sn.simulate(replace(scene, record_every=7))
    for name in LINK_FIELDS:
        kept = np.concatenate([getattr(fine, name)[:-1:7], getattr(fine, name)[-1:]])
        assert kept.tobytes() == getattr(rough, name).tobytes()


def turned(y: np.ndarray, angle: float) -> np.ndarray:
    """Return a state (4 n + 2,) with everything turned about the origin."""
    (x, y_, vx, vy), tail = y[:-2].reshape(4, -1), y[-2:]
    c, s = math.cos(angle), math.sin(angle)
    parts = [c * x - s * y_, s * x + c * y_, c * vx - s * vy, s * vx + c * vy]
    return np.concatenate([*parts, tail + np.array([angle, 0.0])])


def test_the_ground_has_no_preferred_direction() -> None:
    scene = scene_of(7)
    start = start_state(scene)
    straight = end_of(scene, start)
    for angle in (1.0, math.pi / 2, 200.0):
        places = turned(packed(start), angle)[:-2].reshape(4, -1)
        names = ("x_m", "y_m", "vx_m_s", "vy_m_s")
        askew = replace(moved(start, angle), **dict(zip(names, places, strict=True)))
        assert (
            off(end_of(scene, askew), turned(straight, angle)) < 1e-11
        )  # 200 rad are rounded to 3e-14


def test_without_friction_springs_change_no_momentum() -> None:
    """Whatever they do, their forces come in pairs: the sum of velocities keeps to round-off."""
    scene = replace(scene_of(7), ground=sn.Ground(0.0, 0.0), gap="zero", duration_s=20.0)
    start = moved(start_state(scene), 0.0, np.random.default_rng(2).normal(size=7))
    end, start_ = end_of(scene, start), packed(start)
    for part in (slice(14, 21), slice(21, 28)):
        # 2e4 steps, each rounding seven velocities of some m/s: a walk of 2e-16 sqrt(1.4e5)
        assert abs(end[part].sum() - start_[part].sum()) < 1e-12
        assert np.abs(end[part] - start_[part]).max() > 0.1
