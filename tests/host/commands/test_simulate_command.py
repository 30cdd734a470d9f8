"""`serpenoid simulate`: options, scene files, answer, output files and refusals."""

from __future__ import annotations

import dataclasses
import math
from operator import attrgetter
from pathlib import Path

import pytest
import serpenoid as sn
from command_line import answer, serpenoid
from robots import PAPER, VISCOUS, gait_in_deg

GAIT = "simulate --alpha-deg 30 --beta-deg 80 --omega-rad-s 5"
SHORT = f"{GAIT} --robot paper --duration-s 0.2"
# All options of the scene except other drives: typed value, field of the scene, expected value.
OPTIONS = {
    "links": ("4", "robot.links", 4),
    "mass_kg": ("2", "robot.link_mass_kg", 0.5),
    "link_length_m": ("0.2", "robot.link_length_m", 0.2),
    "link_inertia_kg_m2": ("0.003", "robot.link_inertia_kg_m2", 0.003),
    "ct": ("1.5,4", "ground.ct", (0.375, 1.0)),
    "cn": ("12", "ground.cn", 3.0),
    "ft0": ("0.5", "ground.ft0", 0.125),
    "fn0": ("1", "ground.fn0", 0.25),
    "--alpha-deg": ("40", "gait.alpha_rad", math.radians(40)),
    "--beta-deg": ("50", "gait.beta_rad", math.radians(50)),
    "--frequency-hz": ("2", "gait.omega_rad_s", 4 * math.pi),
    "offset_deg": ("5", "gait.offset_rad", math.radians(5)),
    "--formulation": ("implicit", "formulation", "implicit"),
    "joint_stiffness_n_m": ("2000", "joint_stiffness_n_m", 2000.0),
    "joint_damping_n_s_m": ("2", "joint_damping_n_s_m", 2.0),
    "--incline-deg": ("3", "incline_rad", math.radians(3)),
    "incline_direction_deg": ("90", "incline_direction_rad", math.radians(90)),
    "--servo": ("SG90", "servo", sn.servo("SG90").servo),
    "limp": ("2", "limp", (2,)),
    "--method": ("dop853", "method", "dop853"),
    "dt_s": ("0.00025", "dt_s", 0.00025),
    "tolerance": ("1e-5", "tolerance", 1e-5),
    "--duration-s": ("0.01", "duration_s", 0.01),
    "start": ("zero_momentum", "start", "zero_momentum"),
    "gap": ("zero", "gap", "zero"),
    "record": ("joints,friction,energy", "record", ("joints", "friction", "energy")),
    "record_every": ("3", "record_every", 3),
}


def as_typed(name: str, value: str) -> str:
    return f"{name} {value}" if name.startswith("--") else f"--set {name}={value}"


def test_every_field_has_its_option(tmp_path: Path) -> None:
    fields = {name.split(".")[-1] for _, name, _ in OPTIONS.values()} | {
        "drive",
        "torque",
        "locked",
    }
    fields |= {"joint_gain", "joint_shift_rad"}  # one value a joint: only in scene files and Python
    for kind in (sn.Scene, sn.Robot, sn.Ground, sn.Gait):
        names = {f.name for f in dataclasses.fields(kind)} - {"robot", "ground", "gait"}
        names -= {"joint_gain", "joint_shift_rad"}
        assert names <= fields, kind
    path = tmp_path / "scene.toml"
    # The implicit formulation on dry ground has no method with a tolerance.
    viscous = "--set ft0=0 --set fn0=0", ("ct", "ft0", "fn0", "--servo")
    dry = "", ("--method", "tolerance")
    for ground, omitted in (viscous, dry):
        options = {name: option for name, option in OPTIONS.items() if name not in omitted}
        line = " ".join(as_typed(option, value) for option, (value, *_) in options.items())
        answer(f"simulate {line} {ground} --save-scene {path}")
        scene = sn.load_scene(path)
        for option, (_, name, expected) in options.items():
            assert attrgetter(name)(scene) == expected, option
        assert scene.drive == ("angle" if "--servo" in omitted else "servo")


def test_inertia_follows_the_mass_unless_it_is_given(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    for inertia, expected in ((None, 2 * 0.12**2 / 12), (0.7, 0.7)):
        sn.save_scene(
            sn.Scene(sn.Robot(6, 1.0, 0.12, inertia), VISCOUS, sn.Gait(0.5, 1, 5)),
            path,
        )
        result = answer(f"simulate --scene {path} --set mass_kg=12 --duration-s 0.01")
        assert result["scene"]["robot"]["link_inertia_kg_m2"] == pytest.approx(expected, rel=1e-15)


def test_the_answer_and_the_files_hold_the_run(tmp_path: Path) -> None:
    out, figure = tmp_path / "run.csv", tmp_path / "run.png"
    recorded = "--duration-s 2 --set record=joints,friction,energy --set record_every=100"
    result = answer(f"{SHORT} {recorded} --out {out} --plot {figure}")
    scene = sn.Scene(
        PAPER,
        VISCOUS,
        gait_in_deg(30, 80, 5.0),
        duration_s=2.0,
        record_every=100,
        record=("joints", "friction", "energy"),
    )
    run = sn.simulate(scene)
    assert result["steps"] == run.steps == 2000
    assert result["end"]["vx_m_s"] == run.vx_m_s[-1].tolist()
    energy = result["energy_at_end"]
    change = energy["kinetic_j"] - run.energy_j[0, 0]
    assert change == pytest.approx(energy["joint_work_j"] - energy["friction_heat_j"], rel=1e-6)
    assert result["largest_joint_torque_nm"] == abs(run.joint_torque_nm).max(axis=0).tolist()
    assert result["warnings"] == []

    assert len(out.read_text().splitlines()) == 1 + 21
    assert figure.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("simulate --omega-rad-s 5", "give --alpha-deg"),
        (f"{SHORT} --set 'limp=2;3'", "type a number without its unit"),
        (f"{SHORT} --set limp=7", "a joint of limp is 7"),
        (f"{SHORT} --set record=work", "record is 'work'"),
        (f"{SHORT} --scene nowhere.toml", "nowhere.toml: No such file"),
        (f"{SHORT} --set joint_stiffness_n_m=5", "joint_stiffness_n_m would change nothing"),
        (f"{SHORT} --set ct=0.1,-1", "ct backwards is -1.0"),
        (f"{SHORT} --set ft0=0.1,0.2,0.3", "two: forwards, backwards"),
        (f"{SHORT} --incline-deg 100", "--incline-deg': 100.0 is not in the range"),
    ],
)
def test_a_refusal_names_the_typed_option(line: str, message: str) -> None:
    result = serpenoid(line)
    assert result.returncode in (1, 2)
    assert message in result.stderr


def test_an_accuracy_chooses_the_step_or_is_refused_with_a_reason() -> None:
    springs = f"{SHORT} --formulation implicit --method rk4 --accuracy"
    result = answer(f"{springs} 0.05")
    assert (result["formulation"], result["method"]) == ("implicit", "rk4")
    assert "the springs alone (k = 1000 N/m)" in serpenoid(f"{springs} 1e-6").stderr


def test_a_long_run_reports_its_progress(monkeypatch) -> None:
    monkeypatch.setattr("serpenoid.show.screen.REPORT_S", 1e-3)
    line = "simulate --alpha-deg 30 --beta-deg 80 --frequency-hz 1 --duration-s 60 --no-error"
    messages = serpenoid(line).stderr
    assert "simulating, " in messages
