"""The treadmill that one practises at: what its buttons do, and what can be read there."""

from __future__ import annotations

import math
import re
import time

import pytest
from robots import OF_2005
from serpenoid import Ground
from serpenoid.lab.instruments import Instrument
from serpenoid.lab.person import Display
from serpenoid.lab.practice import PracticeTreadmill
from serpenoid.lab.robot import LabRobot, pose_of

ROBOT = LabRobot.whole(OF_2005, Ground(0.084, 1.2, 0.14, 0.27))


def treadmill(joints=(0.0,) * 5, **more):
    told = list(joints)
    made = PracticeTreadmill(ROBOT, lambda: told, Display(scale=1.0), **more)
    return made, told


def number(text, unit):
    found = re.search(rf"([-+]?\d+\.?\d*) {unit}", text)
    assert found is not None, text
    return float(found[1])


def test_raised_and_run_the_robot_holds_near_the_balance():
    room, _ = treadmill()
    for _ in range(8):  # 4 %: 2.29 deg, 0.45 m/s
        shown = room.buttons["steeper"]()
    assert number(shown, "%") == 4.0
    assert number(room.inclinometer(), "deg") == pytest.approx(2.3)
    for _ in range(16):
        shown = room.buttons["faster"]()
    assert number(shown, "km/h") == 1.6
    room.pass_time(3.0)  # the belt takes its time, the robot in the hand
    room.put()
    room.pass_time(5.0)
    assert room.state()["lies"]
    room.mark()
    assert room.state()["watch_s"] == 0.0
    room.pass_time(4.0)
    assert abs(number(room.mark(), "m/s")) < 0.05


def test_a_belt_too_fast_carries_the_robot_off_and_it_can_be_put_back():
    room, _ = treadmill()
    room.set_belt(40)
    room.put()
    room.pass_time(10.0)
    assert not room.state()["lies"]
    assert "off the belt" in room.look()
    assert "not on the belt" in room.mark()
    room.buttons["put_up"]()
    assert "head uphill" in room.put("up")
    assert room.state()["lies"]


def test_instruments_show_their_errors():
    zero = math.radians(0.3)
    room, told = treadmill(
        inclinometer_rad=Instrument(zero=zero, step=math.radians(0.1)), deck_rad=0.01
    )
    one, other = number(room.inclinometer(), "deg"), number(room.buttons["turned"](), "deg")
    assert (one + other) / 2 == pytest.approx(0.3, abs=0.051)
    told[:] = pose_of((1, -1, 0, 0, -1, 1), math.radians(7.5))
    assert number(room.protractor(), "deg") == pytest.approx(165.0, abs=2.0)
    room.pass_time(0.1)
    assert len(room.state()["chain"]) == 7


def test_the_joints_steer_as_the_board_is_told():
    turned = []
    for offset in (0.03, -0.03):
        room, told = treadmill()
        room.set_grade(8)
        room.set_belt(16)
        room.put()
        told[:] = [offset] * 5
        room.pass_time(2.0)
        turned.append(room.belt.look().heading_rad)
    assert turned[0] > 0.1
    assert turned[1] < -0.1


def test_limits_of_the_treadmill():
    room, _ = treadmill()
    assert number(room.set_belt(-3), "km/h") == 0.0
    assert number(room.set_grade(-1), "%") == 0.0
    assert number(room.set_grade(99), "%") == 15.0
    slow = PracticeTreadmill(ROBOT, lambda: [0.0] * 5, Display(least_m_s=0.25))
    assert number(slow.buttons["faster"](), "m/s") == pytest.approx(0.25)
    assert number(slow.buttons["slower"](), "m/s") == 0.0


def test_it_runs_by_the_clock():
    room, _ = treadmill(pace=20.0)
    room.put()
    room.start()
    time.sleep(0.3)
    room.stop()
    assert 1.0 < room.belt.t_s < 60.0
