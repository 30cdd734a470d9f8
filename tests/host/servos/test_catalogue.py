"""Kinds of servos: their numbers, their draws, their files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from refusals import refused


def turned(servo: sn.Servo, drives: bool) -> tuple[float, float]:
    """Return rate, rad/s, and torque against a stop, N m, of a whole servo at full duty.

    A run in time: motor and gear, as Servo says, with a stiff supply and nothing on the horn. It
    knows no formula of a no-load speed. drives: whether a stop holds the horn.
    """
    rate, stop_nm, h = 0.0, 0.0, 2e-5
    line = servo.torque_limit_nm / servo.speed_limit_rad_s
    for _ in range(50_000):
        motor = servo.torque_limit_nm - line * rate - servo.gear_damping_nms_rad * rate
        if drives:  # the stop gives way at a hair's speed, so that the gear's friction acts
            rate, stop_nm = 1e-6, motor - servo.gear_friction_nm
            break
        rate = max(rate + h * (motor - servo.gear_friction_nm) / servo.armature_kg_m2, 0.0)
    return rate, stop_nm


@pytest.mark.parametrize("name", ["hobby", "MG996R", "XL-320"])
def test_drawn_servos_turn_and_pull_as_the_sheet_says(name: str) -> None:
    """Within the sheet's sigma, whatever gear was drawn: of the whole servo, not of its motor."""
    kind = sn.servo(name)
    known = kind.at_volts(kind.servo.supply_v)
    runs = [(turned(s, False)[0], turned(s, True)[1]) for s in known.draws(40, 4)]
    typical = turned(kind.servo, False)[0], turned(kind.servo, True)[1]
    off = np.log(np.array(runs) / typical)
    for column, field in enumerate(("speed_limit_rad_s", "torque_limit_nm")):
        assert off[:, column].std() == pytest.approx(kind.sigma[field], rel=0.2)
        assert abs(off[:, column].mean()) < 0.4 * kind.sigma[field]
    rates, pulls = np.array(runs).T
    assert [s.no_load_rad_s for s in known.draws(40, 4)] == pytest.approx(rates, rel=1e-3)
    assert [s.stall_torque_nm for s in known.draws(40, 4)] == pytest.approx(pulls, rel=1e-3)


def test_voltage_moves_torque_and_speed_and_leaves_the_gear() -> None:
    servo = sn.servo("MG996R").servo.at_volts(6.0)
    less = servo.at_volts(5.0)
    assert less.torque_limit_nm == pytest.approx(5 / 6 * servo.torque_limit_nm)
    assert less.speed_limit_rad_s == pytest.approx(5 / 6 * servo.speed_limit_rad_s)
    assert turned(less, False)[0] < 5 / 6 * turned(servo, False)[0]  # friction stays
    gear = ("gear_friction_nm", "gear_damping_nms_rad", "armature_kg_m2", "damping_nms_rad")
    assert [getattr(less, n) for n in gear] == [getattr(servo, n) for n in gear]
    assert less.at_volts(6.0).no_load_rad_s == pytest.approx(servo.no_load_rad_s)
    with refused("nothing says for which voltage"):
        sn.Servo().at_volts(5.0)


def sheet_rows() -> list[list[str]]:
    """Return the rows of the docs' table that have a sheet's numbers: name, kg cm, s, V, ..."""
    text = (Path(__file__).parents[3] / "docs" / "servos.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    return [row for row in rows if len(row) == 6 and row[2].replace(".", "").isdigit()]


@pytest.mark.parametrize("row", sheet_rows(), ids=lambda row: row[0])
def test_a_servo_does_what_its_sheet_says(row: list[str]) -> None:
    """The whole servo, at the sheet's voltage; a kg cm is 0.0980665 N m."""
    servo = sn.servo(row[0]).servo.at_volts(float(row[3]))
    rate, stalled = turned(servo, False)[0], turned(servo, True)[1]
    assert stalled == pytest.approx(float(row[1]) * 0.0980665, rel=1e-4)
    assert math.radians(60) / rate == pytest.approx(float(row[2]), rel=1e-4)
    # a motor of its own, inside the four that were identified: 18 to 51 ms, 1.5 to 13 % friction
    line = servo.torque_limit_nm / servo.speed_limit_rad_s
    assert 0.018 < servo.armature_kg_m2 / line < 0.051
    assert servo.damping_nms_rad == pytest.approx(line)
    assert 0.015 < servo.gear_friction_nm / servo.torque_limit_nm < 0.13


def test_a_kind_comes_back_from_its_file(tmp_path: Path) -> None:
    for name in ("hobby", "XL-320", *(row[0] for row in sheet_rows())):
        kind = sn.servo(name)
        path = tmp_path / f"{kind.name}.toml"
        sn.save_servo(kind, path)
        old = path.read_text().replace("[servo]\n", "[servo]\nbacklash_rad = 0.0\n")
        path.write_text(old)  # as files of earlier states have it
        assert sn.load_servo(path) == kind == sn.servo(path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("format = 2\n[servo]\n", ":1: format is 2"),
        ("format = 1\n[servo]\nstiffness = 3\n", ":3: unknown key 'stiffness'"),
        ("format = 1\n[servo]\narmature_kg_m2 = -1\n", "armature_kg_m2 is -1"),
        ("format = 1\n[servo]\nbacklash_rad = 0.01\n", "serpenoid no longer has play"),
        ("format = 1\n[servo]\n[sigma]\nframe_s = 0.1\n", ":4: unknown key 'frame_s'"),
        ("format = 1\n[servo]\n[sigma]\nsupply_sag = 9\n", ":4: supply_sag is 9"),
        ("format = 1\n", "missing key servo"),
        ("format = 1\n[servo]\n[sigma]\nsupply_v = 0.1\n", "the servo has none"),
        ("format = 1\n[servo]\ngear_friction_nm = 1\n[sigma]\nsupply_sag = 1\n", "no servo moves"),
    ],
)
def test_a_file_that_is_no_servo_is_refused(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(sn.BadInput) as error:
        sn.servo(path)
    assert says in str(error.value)


def test_an_unknown_name_is_told_the_known_ones() -> None:
    assert sn.servo("sg90") is sn.servo("SG-90") is sn.servo("SG90")
    with refused(r"known are hobby, SG90.*NAME\.toml"):
        sn.servo("SG91")


def test_a_kind_is_made_of_servos() -> None:
    for one in ({"servo": math.inf}, {"servo": sn.Servo(), "drawn": (math.nan,)}):
        with refused(r"servo is a float; it must be a serpenoid\.Servo"):
            sn.ServoKind("x", **one)
