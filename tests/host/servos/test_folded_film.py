"""Run and rest of joints in films: the lab's robot, which no solver of ours moves, is filmed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import serpenoid as sn
from lab.filmed_robot import Motion, driven
from robots import BINGHAM, OF_2005, gait_in_deg
from serpenoid.periodic.servo_steady import servo_state
from serpenoid.servos.folded_film import Ripple, film_ripples

WHOLE = sn.Ground(0.084, 1.2, 0.14, 0.27)
GAIT = gait_in_deg(70, 75, math.tau * 0.5)
HEAVY = sn.servo("MG996R").servo
LIGHT = replace(HEAVY, armature_kg_m2=HEAVY.armature_kg_m2 / 40, update_hz=0.0)
FRAME_S = 0.02


@pytest.fixture(scope="module")
def runs() -> dict[str, Motion]:
    """Return the lab's motion with a heavy rotor and with a light one."""
    servos = {"heavy": HEAVY, "light": LIGHT}
    return {n: driven(OF_2005, WHOLE, GAIT, s, 4.4, 4.0) for n, s in servos.items()}


def filmed(run: Motion, every: int = 5, noise_deg: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """Return times and joints of each `every`-th tick, the tags' noise in them."""
    joints = run.joints_rad[::every]
    noise = np.random.default_rng(5).normal(size=joints.shape)
    return run.t_s[::every], joints + math.radians(noise_deg) * noise


def made(servo: sn.Servo, seen: tuple[Ripple, ...]) -> list[float]:
    """Return the same ripples as the quick state has them."""
    ideal = sn.steady_gait(OF_2005, BINGHAM, GAIT, rtol=1e-3, powers=False)
    return [math.hypot(*servo_state(ideal, servo, watch=list(r.harmonics)).lines) for r in seen]


@pytest.mark.parametrize(("name", "servo"), [("heavy", HEAVY), ("light", LIGHT)])
def test_a_quick_film_shows_the_ripples_that_the_state_has(runs, name, servo) -> None:
    """Two codes moved the joints; the light rotor runs and rests, the heavy one does not."""
    clean = film_ripples(*filmed(runs[name], noise_deg=0.0), GAIT.omega_rad_s, FRAME_S)
    slow, frames = made(servo, clean)
    assert math.sqrt(clean[0].square) == pytest.approx(slow, rel=0.08, abs=2e-3)
    assert math.sqrt(clean[1].square) == pytest.approx(frames, rel=0.1, abs=0.01)
    assert frames > 0.3 if name == "light" else frames < 0.03
    noisy = film_ripples(*filmed(runs[name]), GAIT.omega_rad_s, FRAME_S)
    for ripple, true in zip(noisy, clean, strict=True):
        assert abs(ripple.square - true.square) < 3 * ripple.sigma
        assert ripple.harmonics == true.harmonics


def test_noise_alone_is_no_ripple() -> None:
    t = np.arange(1000) / 240
    sine = GAIT.alpha_rad * np.sin(GAIT.omega_rad_s * t)[:, None] * np.ones(5)
    sine += math.radians(0.3) * np.random.default_rng(1).normal(size=sine.shape)
    for ripple in film_ripples(t, sine, GAIT.omega_rad_s, FRAME_S):
        assert abs(ripple.square) < 3 * ripple.sigma


@pytest.mark.parametrize(
    "t_s",
    [np.arange(8) / 240, np.arange(100) / 240, np.arange(40) * 0.9],
    ids=["few", "short", "slow"],
)
def test_too_few_or_too_slow_pictures_tell_nothing(t_s: np.ndarray) -> None:
    joints = np.sin(GAIT.omega_rad_s * t_s)[:, None] * np.ones(5)
    assert film_ripples(t_s, joints, GAIT.omega_rad_s, FRAME_S) == ()
