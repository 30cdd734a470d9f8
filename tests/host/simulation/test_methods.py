"""Every method converges with the order that its entry declares, in all that it says it runs."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from serpenoid import _core
from serpenoid.simulation import stability
from serpenoid.simulation.core_run import core_request
from serpenoid.simulation.methods import METHODS

ROBOT, GROUND = sn.Robot(4, 0.08, 0.09, 2.5e-4), sn.Ground(0.3, 3.0)
GAIT = sn.Gait(math.radians(40), math.radians(70), 4.0)
# neither limits nor a dead band, which would bend its line
SERVO = sn.Servo(0.3, 0.02, 1e6, 1e6, 0.0)
TABLE = sn.TorqueTable(np.array([0.03, 0.1]), np.array([[0.02, -0.01, 0.03], [0.0, 0.01, -0.02]]))
DRIVES = {
    "angle": {},
    "torque": {"torque": TABLE},
    "servo": {"servo": SERVO},
}
FIXED = [
    (method, formulation, drive)
    for method, kind in METHODS.items()
    for formulation in kind.formulations
    if formulation not in kind.adaptive
    for drive in kind.drives
]


def end_of(scene: sn.Scene, steps: int) -> np.ndarray:
    """Return the state at the end of a run in so many steps."""
    scene = replace(scene, dt_s=scene.duration_s / steps, record_every=steps)
    return sn.simulate(scene).state().packed()


@pytest.mark.parametrize(("method", "formulation", "drive"), FIXED)
def test_a_method_has_the_order_it_declares(method: str, formulation: str, drive: str) -> None:
    """Jumps and kinks of the drives (frames of 20 ms, rows of a table) included."""
    scene = sn.Scene(
        ROBOT,
        GROUND,
        GAIT,
        formulation=formulation,
        drive=drive,
        **DRIVES[drive],
        method=method,
        limp=(2,),
        joint_stiffness_n_m=300.0,
        joint_damping_n_s_m=1.0,
        incline_rad=0.1,
        duration_s=0.12,
        start="link1_at_rest",
    )
    exact = end_of(replace(scene, method="rk4"), 960)
    order = METHODS[method].order
    counts = (60, 120) if order > 2 else (240, 480)
    errors = [np.abs(end_of(scene, steps) - exact).max() for steps in counts]
    assert errors[0] < 0.1
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("c", [1.0, 300.0])
@pytest.mark.parametrize(
    "method", sorted({m for m, formulation, _ in FIXED if formulation == "implicit"})
)
def test_a_step_is_refused_from_where_runs_begin_to_grow(method: str, c: float) -> None:
    """Just inside the limit a disturbance of the gaps decays; a tenth outside it explodes."""
    still = sn.Scene(
        ROBOT,
        sn.Ground(0, 0),
        sn.Gait(0.0, 0.0, 1.0),
        formulation="implicit",
        method=method,
        joint_stiffness_n_m=1e4,
        joint_damping_n_s_m=c,
        start="link1_at_rest",
    )
    limit = stability.largest_stable_step_s(still)
    ajar = 1e-9 * np.random.default_rng(3).normal(size=(2, 4))
    start = sn.LinkState.joined(ROBOT, np.zeros(6), np.zeros(6))
    start = replace(start, x_m=start.x_m + ajar[0], y_m=start.y_m + ajar[1]).packed()
    opened = []
    for factor in (0.98, 1.1):
        dt = factor * limit
        scene = replace(still, dt_s=dt, duration_s=80_000 * dt, record_every=80_000)
        out = _core.run(core_request(scene), start, None)  # without the refusal
        gaps = np.abs(np.diff(out["x_m"][-1]) - ROBOT.link_length_m).max()
        opened.append(gaps if out["failed_at"] < 0 else math.inf)
    assert opened[0] < 1e-6
    assert opened[1] > 1e-3


WAY_OUT = r"(method|formulation|record without) ('\w+'(?: or '\w+')*)"


def scenes_of_every_kind() -> list[dict[str, Any]]:
    """Return what a scene may ask for, in all combinations that make a difference to a method."""
    drives: list[dict[str, Any]] = [
        {},
        {"drive": "torque", "torque": [0.0, 0.0]},
        {"drive": "servo", "servo": sn.Servo()},
        {"limp": (1,)},
        {"incline_rad": 0.1},
    ]
    grounds: list[dict[str, Any]] = [
        {"ground": sn.Ground(0.1, 1.0)},
        {"ground": sn.Ground(0.1, 1.0, 0.01, 0.02)},
        {"ground": sn.Ground(0.1, 1.0, 0.01, 0.02), "smoothing_m_s": 1e-2},
    ]
    records: list[dict[str, Any]] = [{}, {"record": ("energy",)}, {"record": ("joints",)}]
    return [
        {"formulation": formulation, **drive, **ground, **record}
        for formulation in ("explicit", "implicit")
        for drive in drives
        for ground in grounds
        for record in records
    ]


@pytest.mark.parametrize("asked", scenes_of_every_kind())
def test_every_way_out_that_an_error_names_runs(asked: dict[str, Any]) -> None:
    """Follow the advice for every method: it leads to a scene, never to the next error."""
    robot, gait = sn.Robot(3, 1.0, 0.12), sn.Gait(0.3, 0.5, 3.0)
    fields = {"robot": robot, "gait": gait, "duration_s": 2e-3, "dt_s": 1e-3, **asked}
    sn.simulate(sn.Scene(**fields))  # by the method that it takes itself
    for method in METHODS:
        try:
            sn.Scene(**fields, method=method)
        except sn.BadInput as error:
            advice = str(error).split("; take ")[1]
            for way in re.findall(
                r"(method|formulation|record without) ('\w+'(?: or '\w+')*)", advice
            ):
                for word in re.findall(r"\w+", way[1].replace(" or ", " ")):
                    sn.simulate(
                        sn.Scene(**(fields | {"method": method} | change(way[0], word, asked)))
                    )


def change(what: str, word: str, asked: dict[str, Any]) -> dict[str, Any]:
    if what == "record without":
        return {"record": tuple(r for r in asked["record"] if r != word)}
    return {what: word}


def test_a_scene_that_names_no_method_chooses_anew_when_changed() -> None:
    smooth = sn.Scene(sn.Robot(3, 1.0, 0.12), sn.Ground(0.1, 1.0), sn.Gait(0.3, 0.5, 3.0))
    dry = sn.Ground(0.1, 1.0, 0.01, 0.02)
    assert smooth.method == "rk4"
    assert replace(smooth, ground=dry).method == "nonsmooth"
    assert replace(smooth, ground=dry, smoothing_m_s=1e-2).method == "rk4"
    assert replace(replace(smooth, method="rk4"), ground=dry).method == "rk4"
