"""Servos from measurements: truths that no fit is told, by codes that share no step with it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from command_line import serpenoid
from lab.one_joint import ROBOT, filmed_by, shown_by
from robots import BINGHAM, gait_in_deg
from serpenoid import ServoSteady
from serpenoid.periodic.servo_steady import with_servo
from serpenoid.servos import bench_test
from serpenoid.servos.bench_test import moved, servo_of_test, shown

GAIT = gait_in_deg(70, 75, math.tau * 0.5)


def test_the_models_joint_moves_as_the_labs() -> None:
    """Loops look between the model's steps, too."""
    off = []
    for true in sn.servo().draws(12, 105):
        film = filmed_by(true, 0, 0.0)
        off.append(np.std(moved(film, [true], np.zeros(1))[0] - film.angle_rad))
    assert np.mean(off) < math.radians(0.04)


def driven(ground: sn.Ground, kind: sn.ServoKind) -> ServoSteady:
    """Return what a kind of servo makes of the gait, by few draws."""
    return with_servo(sn.steady_gait(ROBOT, ground, GAIT, rtol=1e-3), kind, draws=64)


@pytest.mark.slow
@pytest.mark.parametrize(("camera", "seed"), [(shown_by, 102), (filmed_by, 104)])
def test_a_bench_test_tells_the_servo(camera, seed, monkeypatch) -> None:
    """It predicts the crawl's speed then, with 0.6 of the doubt by 50 looks, with 0.12 by 240.

    In a film pictures and setpoints fall at different times.
    """
    monkeypatch.setattr(bench_test, "PARTICLES", 96)
    true = sn.servo().draws(1, seed)[0]
    found = servo_of_test(camera(true, seed), sn.servo())
    for name, within in (
        ("no_load_rad_s", 0.05),
        ("stiffness_over_torque", 0.2),
        ("rotor_over_brake_s", 0.35),
    ):
        assert found.shown[name].value == pytest.approx(shown(true)[name], within)
    assert "no_load_rad_s" not in found.untold
    crawls = sn.steady_gait(ROBOT, BINGHAM, GAIT, rtol=1e-3, servo=true).speed_m_s
    known, before = (driven(BINGHAM, kind) for kind in (found.kind, sn.servo()))
    assert known.low_m_s * 0.98 < crawls < known.high_m_s * 1.02
    assert known.high_m_s - known.low_m_s < 0.7 * (before.high_m_s - before.low_m_s)


def test_a_table_may_have_its_setpoints_a_row_late() -> None:
    """As of each picture: the servo then seems to have heard before."""
    film = filmed_by(sn.servo().servo, 1)
    late = replace(film, setpoint_rad=np.roll(film.setpoint_rad, 1))
    units = np.zeros((601, 12))
    units[:, -2:] = np.linspace([-3, -1], [3, -1], 601)
    assert bench_test._Posterior(late, sn.servo()).chi2(units).min() < len(film.t_s)


def test_what_a_joint_does_not_show_is_an_unknown_by_itself() -> None:
    """With more damping in the gear, or more volts, rotor and speed follow: it moves alike."""
    posterior = bench_test._Posterior(shown_by(sn.servo().servo, 1), sn.servo())
    unknowns = np.zeros((3, sum(posterior.free)))
    unknowns[1, 4] = unknowns[2, 8] = 1.0  # gear, voltage; 1.2 and 3 degrees if nothing followed
    servos = posterior.servos(posterior.units(unknowns))
    angle, *others = moved(posterior.test, servos, np.zeros(3))
    assert np.abs(others - angle).max() < math.radians(0.4)
    # so what is stated of a servo keeps its sigma, whatever the gear and the voltage
    brake = [shown(servo)["rotor_over_brake_s"] for servo in servos]
    assert brake == pytest.approx(brake[:1] * 3)


@pytest.mark.slow
def test_the_command_writes_a_file_that_others_take(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(bench_test, "PARTICLES", 96)
    monkeypatch.setattr(bench_test, "KEPT", 32)
    true = sn.servo().draws(1, 103)[0]
    test = shown_by(true, 1)
    table, out = tmp_path / "joint.csv", tmp_path / "mine.toml"
    rows = zip(test.t_s, np.degrees(test.setpoint_rad), np.degrees(test.angle_rad), strict=True)
    table.write_text("t_s,setpoint_deg,angle_deg\n" + "".join(f"{t},{s},{a}\n" for t, s, a in rows))
    told = serpenoid(f"servo --test {table} --out {out}", check=True).stdout
    assert told.startswith("Without load the servo turns at about ")
    assert "gear_damping_over_motors" in told
    kind = sn.servo(out)
    assert len(kind.drawn) == 32


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("t_s,angle_deg\n0,1\n", "no column setpoint_deg"),
        ("", "no column t_s"),
        ("t_s,setpoint_deg,angle_deg\n0,1,x\n", ":2: angle_deg is no finite number"),
        ("t_s,setpoint_deg,angle_deg\n" + "0,1,0\n" * 12, "rising times"),
        ("t_s,setpoint_deg,angle_deg\n" + "".join(f"{k},1,0\n" for k in range(12)), "never chang"),
        ("t_s,setpoint_deg,angle_deg\n" + "".join(f"{9 * k},{k},0\n" for k in range(12)), "20 s"),
        (
            "t_s,setpoint_deg,angle_deg\n" + "".join(f"{k},{k},nan\n" for k in range(12)),
            ":2: angle_deg is no finite number",
        ),
    ],
)
def test_a_table_that_is_no_test_is_refused(tmp_path: Path, text: str, says: str) -> None:
    table = tmp_path / "joint.csv"
    table.write_text(text)
    told = serpenoid(f"servo --test {table}")
    assert told.returncode in (1, 2)
    assert says in told.stderr
    assert "--sigma-deg is -1" in serpenoid(f"servo --sigma-deg -1 --test {table}").stderr
    assert serpenoid("servo").returncode == 2
