"""The vector kernels, held to a scalar run, to NumPy, and to themselves."""

from __future__ import annotations

import math
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from serpenoid import _core
from serpenoid.bench.cost.scenes import OWN_FLAGS
from serpenoid.model.link_state import LinkState
from serpenoid.simulation.core_run import core_request
from serpenoid.simulation.stability import joint_modes
from serpenoid.simulation.starts import start_state

CORE = Path(__file__).resolve().parents[3] / "host" / "core"
LINK_FIELDS = ("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s")
SETS = _core.instruction_sets()
WIDTH = {"avx512": 4, "avx2": 4, "baseline": 2, "scalar": 1}
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


def kernel_state(state: LinkState) -> np.ndarray:
    """Return x, y, vx, vy of all links, then theta and omega of link 1, (4 n + 2,)."""
    tail = [state.theta_rad[0], state.omega_rad_s[0]]
    return np.concatenate([state.x_m, state.y_m, state.vx_m_s, state.vy_m_s, tail])


def run_kernel(kernels: str, scene: sn.Scene, start: np.ndarray) -> np.ndarray:
    """Run the core's kernels of one name from a given start (4 n + 2,); return the end."""
    return _core.kernel_run(kernels, core_request(scene), start)[0]


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


@pytest.mark.parametrize("kernels", SETS)
@pytest.mark.parametrize(("far", "units"), [(100.0, 1.7), (1e6, 2.5), (1e300, 2.5)])
def test_sine_and_cosine_err_by_a_few_units(kernels: str, far: float, units: float) -> None:
    rng = np.random.default_rng(1)
    quarter = np.arange(-60, 60) * (math.pi / 2)
    x = np.concatenate(
        [
            rng.uniform(-far, far, 100_000),
            far * 10.0 ** rng.uniform(-300, 0, 1000),
            quarter,
            np.nextafter(quarter, 9e9),
            [far, -far, 0.0, 1.0],
        ]
    )
    sine, cosine = _core.kernel_sincos(kernels, x)
    for found, exact in ((sine, np.sin), (cosine, np.cos)):
        truth = exact(x.astype(np.longdouble))  # 64 bits: 2^-11 units of a double
        unit = np.spacing(np.abs(truth.astype(float)))
        assert np.abs((found - truth) / unit).max() < units
    broken = np.array([math.inf, -math.inf, math.nan, 1.0])
    assert np.isnan(_core.kernel_sincos(kernels, broken)).sum() == 6


@pytest.mark.parametrize("kernels", SETS)
@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("tilt", [{}, TILT], ids=["level", "tilted"])
def test_kernels_agree_with_numpy(kernels: str, ground: str, tilt: dict[str, Any]) -> None:
    """200 steps: a few hundred roundings of 1e-16, which the springs pass on but do not grow."""
    gaits = [GAIT, sn.Gait(math.radians(170), 0.3, 7.0, -0.4), sn.Gait(0.0, 0.0, 1.0)]
    headings = [0.3, -40.0, 2e6]  # two far from 0, the last one beyond the fast sine
    for gait, heading in zip(gaits, headings, strict=True):
        scene = scene_of(5, ground, duration_s=0.2, gait=gait, **tilt)
        start = kernel_state(start_state(scene))
        start[-2] += heading
        start[10:20] += 0.1
        exact = numpy_rk4(scene, gait, start, scene.dt_s, 200)
        assert off(run_kernel(kernels, scene, start), exact) < 3e-12


@pytest.mark.parametrize("links", [2, 3, 4, 5, 6, 7, 8, 9, 13, 16, 31, 50, 1000])
def test_every_number_of_links_fits(links: int) -> None:
    """The scalar kernel knows no padding: lanes that stand for no link change nothing."""
    scene = scene_of(links, duration_s=0.2 if links < 100 else 0.02, **TILT)
    start = start_state(scene_of(links, gap="zero"))
    rng = np.random.default_rng(links)
    packed = kernel_state(start) + 1e-3 * rng.normal(size=4 * links + 2)
    exact = run_kernel("scalar", scene, packed)
    for kernels in SETS:
        assert off(run_kernel(kernels, scene, packed), exact) < 1e-12


@pytest.mark.parametrize("kernels", SETS)
@pytest.mark.parametrize("tilt", [{}, TILT], ids=["level", "tilted"])
def test_rk4_of_the_kernels_has_order_four(kernels: str, tilt: dict[str, Any]) -> None:
    scene = scene_of(7, duration_s=1.0, **tilt)
    start = kernel_state(start_state(scene))
    ends = [
        run_kernel(kernels, replace(scene, dt_s=1 / steps), start)
        for steps in (1500, 3000, 6000, 32_000)
    ]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(4, abs=0.2)


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


@pytest.mark.skipif("avx2" not in SETS or not shutil.which("g++"), reason="needs x86 and g++")
@pytest.mark.parametrize("name", ["avx2", "avx512"])
def test_no_code_for_newer_processors_is_shared(tmp_path: Path, name: str) -> None:
    """Compiled without inlining, a unit for wide vectors defines nothing but its table of kernels.

    A linker keeps one copy of every shared inline function: were it this unit's, older processors
    would meet instructions that they do not have.
    """
    unit, flags = (
        tmp_path / "unit.o",
        [f"-I{CORE}", "-std=c++20", "-O0", *OWN_FLAGS[f"{name}.cpp"], "-ffp-contract=off"],
    )
    subprocess.run(
        ["g++", *flags, "-c", str(CORE / "kernels" / f"{name}.cpp"), "-o", str(unit)], check=True
    )
    symbols = subprocess.run(
        ["nm", "-C", "--defined-only", "--extern-only", str(unit)],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    assert [line.split(maxsplit=2)[2] for line in symbols.splitlines()] == [
        f"serpenoid::kernels::{name}"
    ]


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize(("links", "tilt"), [(2, {}), (6, {}), (6, TILT), (9, TILT)])
def test_a_single_run_agrees_with_the_general_method(
    ground: str, links: int, tilt: dict[str, Any]
) -> None:
    """An energy ledger is integrated with the motion, by the general RK4 on the general model."""
    scene = scene_of(links, ground, duration_s=0.2503, record_every=50, **tilt)
    fast, general = sn.simulate(scene), sn.simulate(replace(scene, record=("energy",)))
    assert fast.t_s.tobytes() == general.t_s.tobytes()
    for name in LINK_FIELDS:
        assert np.abs(getattr(fast, name) - getattr(general, name)).max() < 2e-12


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
    start = kernel_state(start_state(scene))
    straight = run_kernel(SETS[0], scene, start)
    for angle in (1.0, math.pi / 2, 200.0):
        askew = run_kernel(SETS[0], scene, turned(start, angle))
        assert off(askew, turned(straight, angle)) < 1e-12


def test_without_friction_springs_change_no_momentum() -> None:
    """Whatever they do, their forces come in pairs: the sum of velocities keeps to round-off."""
    scene = replace(scene_of(7), ground=sn.Ground(0.0, 0.0), gap="zero", duration_s=20.0)
    start = kernel_state(start_state(scene))
    start[14:28] += np.random.default_rng(2).normal(size=14)
    end = run_kernel(SETS[0], scene, start)
    for part in (slice(14, 21), slice(21, 28)):
        # 2e4 steps, each rounding seven velocities of some m/s: a walk of 2e-16 sqrt(1.4e5)
        assert abs(end[part].sum() - start[part].sum()) < 1e-12
        assert np.abs(end[part] - start[part]).max() > 0.1
