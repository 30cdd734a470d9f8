"""Any scene that a file can hold either runs to finite numbers or is refused in so many words.

Scenes are typed as TOML, every field sometimes extreme, and run until a time limit. For a longer
search: SERPENOID_FUZZ_EXAMPLES=100000 pytest tests/host/test_scene_fuzz.py
"""

from __future__ import annotations

import dataclasses
import math
import os
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from serpenoid import load_scene

EXAMPLES = int(os.environ.get("SERPENOID_FUZZ_EXAMPLES", "150"))
LIMIT_S, GRACE_S = 0.05, 10.0
REFUSALS = (sn.BadInput, sn.StepTooLarge, sn.Diverged, sn.NotConverged)


class Enough(Exception):
    """The run was stopped from outside, as Ctrl-C does."""


def across(low: float, high: float) -> st.SearchStrategy[float]:
    """Return numbers spread evenly over the decades from low to high."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


def usual(value: float, extreme: st.SearchStrategy[float]) -> st.SearchStrategy[float]:
    """Return the usual value twice in three times, so that most scenes are odd in few ways."""
    return st.one_of(st.just(value), st.just(value), extreme)


def or_zero(some: st.SearchStrategy[float]) -> st.SearchStrategy[float]:
    return st.one_of(st.just(0.0), some)


angle = st.floats(-math.pi, math.pi)
parts = st.fixed_dictionaries(
    {
        "robot": st.fixed_dictionaries(
            {
                "links": st.one_of(st.integers(2, 8), st.integers(2, 8), st.integers(2, 1000)),
                "mass_kg": usual(0.6, across(1e-6, 1e6)),
                "link_length_m": usual(0.1, across(1e-5, 1e4)),
            },
            optional={"link_inertia_kg_m2": across(1e-15, 1e9)},
        ),
        "ground": st.fixed_dictionaries(
            {
                "ct_n_s_m": usual(0.6, or_zero(across(1e-9, 1e9))),
                "cn_n_s_m": usual(6.0, or_zero(across(1e-9, 1e9))),
                "ft0_n": usual(0.0, across(1e-9, 1e6)),
                "fn0_n": usual(0.0, across(1e-9, 1e6)),
            }
        ),
        "gait": st.fixed_dictionaries(
            {
                "alpha_rad": usual(0.5, st.floats(0, math.pi)),
                "beta_rad": usual(1.3, st.floats(-2 * math.pi, 2 * math.pi)),
                "omega_rad_s": usual(5.0, across(1e-3, 1e3)),
                "offset_rad": usual(0.0, angle),
            }
        ),
    }
)
numbers = st.fixed_dictionaries(
    {
        "formulation": st.sampled_from(("explicit", "implicit")),
        "joint_stiffness_n_m": usual(1e3, or_zero(across(1e-3, 1e12))),
        "joint_damping_n_s_m": usual(1.0, or_zero(across(1e-9, 1e9))),
        "drive": st.sampled_from(("angle", "angle", "torque", "servo")),
        "incline_rad": usual(0.0, st.floats(0, math.pi / 2)),
        "incline_direction_rad": usual(0.0, angle),
        "method": st.sampled_from(("rk4", "paper", "dop853", "radau", "nonsmooth")),
        "dt_s": usual(1e-4, across(1e-9, 10.0)),
        "tolerance": usual(1e-7, across(1e-13, 0.1)),
        "start": st.sampled_from(("link1_at_rest", "link1_at_rest", "zero_momentum", "steady")),
        "gap": st.sampled_from(("slow_manifold", "zero")),
        "record": st.lists(st.sampled_from(("joints", "friction", "energy")), unique=True),
    }
)
servos = st.fixed_dictionaries(
    {},
    optional={
        "stiffness_nm_rad": or_zero(across(1e-6, 1e9)),
        "damping_nms_rad": or_zero(across(1e-9, 1e6)),
        "torque_limit_nm": across(1e-6, 1e6),
        "speed_limit_rad_s": across(1e-3, 1e6),
        "dead_band_rad": or_zero(across(1e-9, 10.0)),
    },
)


@st.composite
def scene_texts(draw: st.DrawFn) -> str:
    """Type a scene file; most run for some 1000 steps."""
    top, tables = draw(numbers), draw(parts)
    joints = tables["robot"]["links"] - 1
    if joints > 30 and top["start"] == "steady":
        top["start"] = "zero_momentum"  # the periodic state of 1000 links takes its time
    top["duration_s"] = draw(
        st.one_of(st.integers(0, 2000).map(lambda k: k * top["dt_s"]), across(1e-6, 1e9))
    )
    if draw(st.booleans()):
        top["record_every"] = draw(st.integers(1, 10**12))
    torque = draw(or_zero(across(1e-9, 1e6)))
    if top["drive"] == "torque":
        rows = [[torque * (-1) ** i for i in range(joints)]] * 2
        constant = draw(st.booleans())
        tables["torque"] = (
            {"torque_nm": rows[0]} if constant else {"t_s": [0.0, 0.1], "torque_nm": rows}
        )
    if top["drive"] == "servo":
        tables["servo"] = draw(servos)
    bad = draw(st.one_of(st.just([]), st.lists(st.integers(1, joints), max_size=3, unique=True)))
    top["limp"] = bad[:1]
    tables["locked_rad"] = {j: draw(angle) for j in bad[1:]}
    lines = [f"{key} = {value!r}" for key, value in {"format": 2, **top}.items()]
    for name, table in tables.items():
        lines += [f"[{name}]", *(f"{key} = {value!r}" for key, value in table.items())]
    return "\n".join(lines)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz") / "scene.toml"


@given(text=scene_texts())
@settings(
    max_examples=EXAMPLES,
    deadline=None,
    database=None,
    derandomize=EXAMPLES <= 150,
    suppress_health_check=list(HealthCheck),
)
def test_any_scene_ends_in_finite_numbers_or_in_words(text: str, path: Path) -> None:
    path.write_text(text)
    began = time.process_time()

    def watch(_t_s: float) -> None:
        if time.process_time() - began > LIMIT_S:
            raise Enough

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "(a link (is|has)|joints bend) ")
        try:
            run = sn.simulate(load_scene(path), progress=watch)
        except (*REFUSALS, Enough):
            run = None
    assert time.process_time() - began < GRACE_S, "it could not be stopped"
    if run is None:
        return
    for field in dataclasses.fields(run):
        if field.name not in ("scene", "picked", "_estimator"):
            assert np.isfinite(getattr(run, field.name)).all(), field.name


def test_a_step_that_lasts_can_be_stopped() -> None:
    scene = sn.Scene(
        sn.Robot(372, 0.1, 0.1),
        sn.Ground(1.0, 1.0, 0.004, 0.0001),
        sn.Gait(1.6, 0.0, 5.0),
        method="nonsmooth",
        duration_s=0.3,
        record_every=300,
    )

    def stop(_t_s: float) -> None:
        raise Enough

    with pytest.raises(Enough):  # half a minute and 200 000 inner steps before its end
        sn.simulate(scene, progress=stop)
