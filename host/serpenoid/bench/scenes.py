"""Measure what each term of a scene costs: processor time of a Runge-Kutta step with it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..base.checks import CHOICES
from ..model.drives import Servo
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.presets import PRESETS
from ..simulation.scene import Scene
from ..simulation.simulate import simulate


@dataclass(frozen=True)
class Cost:
    """The cost of one scene.

    step_us: processor time of a step, microseconds. ratio: step_us over that of the plain scene.
    """

    formulation: str
    scene: str
    step_us: float
    ratio: float


def variants(formulation: str, steps: int) -> dict[str, Scene]:
    """Return scenes by name: the plain one first, and others with one term more."""
    plain = Scene(
        *PRESETS["paper"],
        Gait.degrees(30, 80, omega_rad_s=5.0),
        formulation=formulation,
        method="rk4",
        dt_s=1e-3,
        duration_s=1e-3 * steps,
        record_every=steps,
        gap="zero",
    )
    return {
        "viscous, level": plain,
        "dry friction": replace(plain, ground=Ground(0.1, 10.0, 0.02, 0.05)),
        "ratchet wheels": replace(plain, ground=Ground((0.1, 1.0), 10.0)),
        "incline": replace(plain, incline_rad=0.05),
        "servos": replace(plain, drive="servo", servo=Servo()),
        "a limp joint": replace(plain, limp=(2,)),
        "energy ledger": replace(plain, record=("energy",)),
        "motion recorded each step": replace(plain, record_every=1),
        "forces recorded each step": replace(plain, record_every=1, record=("joints", "friction")),
    }


def measure(quick: bool) -> Iterator[Cost]:
    """Yield the cost of each scene of both formulations; quick: from shorter runs."""
    steps = 5_000 if quick else 20_000
    for formulation in CHOICES["formulation"]:
        plain_us = 0.0
        for name, scene in variants(formulation, steps).items():
            times_s = []
            for _ in range(5):
                start_s = time.thread_time()
                simulate(scene)
                times_s.append(time.thread_time() - start_s)
            step_us = 1e6 * min(times_s) / steps
            plain_us = plain_us or step_us
            yield Cost(formulation, name, step_us, step_us / plain_us)
