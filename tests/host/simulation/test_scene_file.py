"""Scene files: what is written comes back to the last digit, and what is wrong is told where."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused
from robots import OF_2005

ROBOT = sn.Robot(4, 0.1, 1 / 3)
GROUND = sn.Ground(0.014, 0.2, 1e-7, 0.3)
GAIT = sn.Gait(0.1 + 0.2, math.radians(75), math.pi, -0.7)
STATE = sn.LinkState.in_gait(ROBOT, GAIT, 0.0, [0.1, 0.2, 0.3], [1, 2, 3])
TIMES = sn.TorqueTable([0, 1 / 3, 1], np.arange(9).reshape(3, 3) / 7)
PLAIN = """\
format = 2
duration_s = 2
[robot]
links = 6
mass_kg = 0.4536
link_length_m = 0.076
[ground]
ct_n_s_m = 0.084
cn_n_s_m = 1.5
[gait]
alpha_rad = 1.2
beta_rad = 1.3
omega_rad_s = 5.0
"""

SCENES = {
    "defaults": sn.Scene(ROBOT, GROUND, GAIT),
    "numbers": sn.Scene(
        ROBOT,
        GROUND,
        GAIT,
        formulation="implicit",
        joint_stiffness_n_m=1 / 3,
        joint_damping_n_s_m=2e-9,
        incline_rad=0.1,
        incline_direction_rad=-1 / 7,
        method="paper",
        dt_s=1e-3 / 3,
        tolerance=3e-8,
        duration_s=1.1,
        start="zero_momentum",
        gap="zero",
        record=("energy", "joints"),
        record_every=7,
    ),
    "servo": sn.Scene(
        dataclasses.replace(ROBOT, link_inertia_kg_m2=1e-3 / 7),
        GROUND,
        GAIT,
        drive="servo",
        servo=sn.Servo(1 / 3, 0.2, 0.4, 9.1, 0.0),
        limp=(1,),
        locked={3: 0.1 / 3, 2: -1},
    ),
    "torques": sn.Scene(ROBOT, GROUND, GAIT, drive="torque", torque=[0.1, 1 / 3, -2e-8]),
    "torque table": sn.Scene(ROBOT, GROUND, GAIT, drive="torque", torque=TIMES),
    "state": sn.Scene(ROBOT, GROUND, GAIT, start=STATE),
    "ratchet": sn.Scene(ROBOT, sn.Ground((0.1 / 3, 1.0), 2.0, (0.0, 1 / 7)), GAIT),
    "numpy's numbers": sn.Scene(
        ROBOT, GROUND, GAIT, dt_s=np.float32(0.001), duration_s=np.int64(3)
    ),
}


def same(a: Any, b: Any) -> bool:
    """Tell whether two fields hold the same numbers, to the last bit."""
    if dataclasses.is_dataclass(a) and type(a) is type(b):
        names = [f.name for f in dataclasses.fields(a)]
        return all(same(getattr(a, name), getattr(b, name)) for name in names)
    if isinstance(a, (np.ndarray, list, tuple)):
        return bool(np.array_equal(a, b))
    return bool(a == b)


@pytest.mark.parametrize("name", SCENES)
def test_round_trip(name: str, tmp_path) -> None:
    path = tmp_path / "scene.toml"
    sn.save_scene(SCENES[name], path)
    back = sn.load_scene(path)
    for field in dataclasses.fields(sn.Scene):
        was, has = getattr(SCENES[name], field.name), getattr(back, field.name)
        assert same(was, has), (field.name, was, has)
    assert [p.name for p in tmp_path.iterdir()] == ["scene.toml"]


def test_every_field_is_tried() -> None:
    plain = SCENES["defaults"]
    for field in dataclasses.fields(sn.Scene)[3:]:
        values = [getattr(scene, field.name) for scene in SCENES.values()]
        assert any(not same(v, getattr(plain, field.name)) for v in values), field.name


def test_what_is_left_out_has_its_default(tmp_path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(PLAIN)
    scene = sn.load_scene(path)
    assert scene == sn.Scene(OF_2005, sn.Ground(0.014, 0.25), sn.Gait(1.2, 1.3, 5.0), duration_s=2)


def test_angles_in_degrees(tmp_path) -> None:
    path = tmp_path / "scene.toml"
    text = PLAIN.replace("alpha_rad = 1.2", "alpha_deg = 70").replace("beta_rad", "beta_rad")
    path.write_text("incline_deg = 10\nlocked_deg = { 2 = -30 }\n" + text)
    scene = sn.load_scene(path)
    assert scene.gait.alpha_rad == math.radians(70)
    assert scene.incline_rad == math.radians(10)
    assert scene.locked == {2: math.radians(-30)}


def test_a_function_is_not_for_files(tmp_path) -> None:
    scene = sn.Scene(ROBOT, GROUND, GAIT, drive="torque", torque=lambda t: [t] * 3)
    with refused("TorqueTable"):
        sn.save_scene(scene, tmp_path / "scene.toml")
    assert list(tmp_path.iterdir()) == []


def swap(old: str, new: str) -> str:
    assert old in PLAIN
    return PLAIN.replace(old, new)


TORQUE = 'drive = "torque"\n' + PLAIN + "[torque]\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (swap("format = 2", ""), ": the file has no format; it must begin with format = 2"),
        (swap("format = 2", "format = 3"), ":1: format is 3; .* reads formats up to 2"),
        (swap("format = 2", "format = 1"), ":1: format is 1, .* of one link; .* times the links"),
        (PLAIN[: PLAIN.index("[gait]")], ": missing key gait, which has no default"),
        (swap("alpha_rad = 1.2\n", ""), ": missing key alpha_rad, which has no default"),
        (swap("alpha_rad = 1.2", "alhpa_rad = 1.2"), ":11: unknown key 'alhpa_rad'.*'alpha_rad'"),
        (swap("alpha_rad = 1.2", "alpha_rad = nan"), ":11: alpha_rad is nan; .*at most 3.14"),
        (swap("alpha_rad = 1.2", "alpha_rad = 1\nalpha_deg = 70"), ":12: alpha_rad is there too"),
        (swap("links = 6", "links = 1"), ":4: links is 1; .* from 2 to"),
        (swap("ct_n_s_m = 0.084", "ct_n_s_m = [1, -2]"), ":8: ct backwards is -2"),
        (swap("duration_s = 2", "duration_s = 1e20"), ":2: duration_s 1e\\+20 at dt_s"),
        (swap("duration_s = 2", "record = 'joints'"), ":2: record is 'joints'; it must be a list"),
        (swap("duration_s = 2", "locked_rad = {1 = 9}"), r":2: locked\[1\] is 9.0"),
        (swap("duration_s = 2", "method = 'rk5'"), ":2: method is 'rk5'; .*rk4"),
        (PLAIN + "duration_s = 3\n", ":14: unknown key 'duration_s'; known are alpha_rad"),
        (PLAIN + "[start]\nx_m = [1]\n", ": missing key y_m, theta_rad"),
        (swap("duration_s = 2", 'drive = "torque"'), ":2: drive is 'torque' and torque is None"),
        (swap("duration_s = 2", "smoothing_m_s = 0.01"), ":2: smoothing_m_s is 0.01; .* remove"),
        (PLAIN + "[servo]\nbacklash_rad = 0.02", ":15: backlash_rad is 0.02; .* play in gears"),
        (TORQUE + "t_s = [0, 1]\ntorque_nm = [[1], [1, 2]]", ":15: torque_nm is .* regular array"),
        (TORQUE + "t_s = [1, 0]\ntorque_nm = [[1], [1]]", ":15: .* rising t_s"),
        (TORQUE + "t_s = [0]\ntorque_nm = [[1]]", ":15: the torque table has 1 columns"),
        (TORQUE + "t_s = [0]\ntorque_nm = [[nan]]", ":15: a torque table needs finite"),
    ],
)
def test_refusals(text: str, said: str, tmp_path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(text)
    with refused("scene.toml" + said):
        sn.load_scene(path)
