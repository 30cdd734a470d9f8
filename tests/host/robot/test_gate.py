"""One gate for what comes from outside: no such number, line, name or file passes it."""

from __future__ import annotations

import re
from types import SimpleNamespace

import pytest
import serpenoid as sn
from command_line import serpenoid
from refusals import refused
from robot.fake_board import GAIT_TYPED, FakeBoard, greeting
from serpenoid.base.errors import DamagedLine
from serpenoid.robot import Robot
from serpenoid.robot.wire import ports
from serpenoid.robot.wire.protocol import Data
from serpenoid.robot.wire.reports import settings_of


@pytest.fixture(scope="module")
def lines() -> dict[str, list[bytes]]:
    """Return what a board says, by its first word."""
    with Robot("virtual:fast") as robot:
        said: list[bytes] = []
        take = robot._dialogue.inbox.take
        robot._dialogue.inbox.take = lambda line, host_s: (said.append(line), take(line, host_s))
        robot.straight()
        robot.status(), robot.settings(), robot.trims()
    return {w: [x for x in said if x.startswith(w.encode())] for w in ("set:", "trim:")}


@pytest.mark.parametrize("value", ["-1", "0.05", "601", "1_0", "nan", "inf", "1e2", "", "9" * 5000])
def test_settings_that_no_board_can_have_are_damage(lines, value):
    data = [Data("set", x.decode().partition(": ")[2]) for x in lines["set:"]]
    assert settings_of(data)["silence"] == 2.0
    wrong = [
        Data("set", re.sub("^silence value=2", f"silence value={value}", d.text)) for d in data
    ]
    assert wrong != data
    with pytest.raises(DamagedLine):
        settings_of(wrong)


def test_markup_in_a_path_and_in_a_greeting_is_text(tmp_path):
    file = tmp_path / "[" / "b]run[bold].wire"
    file.parent.mkdir()
    with FakeBoard(greeting(rb"board=\S+", b"board=[/b]")) as fake:
        args = f"--port {fake.port} --duration-s 0.3 --record {file}"
        status, said, errors = serpenoid(f"drive {GAIT_TYPED} {args}")
    assert (status, "Traceback" in errors) == (0, False), errors
    assert "[/b], firmware" in said
    assert "run[bold].wire" in re.sub(r"[\s│]", "", said)


@pytest.mark.parametrize(
    "make",
    [
        lambda: sn.Robot(6, 0.1, 1e200),
        lambda: sn.Robot(6, 1e308, 0.1),
        lambda: sn.Robot(6, 1e-320, 0.1),
        lambda: sn.Robot(6, 0.1, 1e-200),
        lambda: sn.Ground(1e300, 1.0),
        lambda: sn.Gait(0.5, 1.0, 5e-324),
        lambda: sn.Gait(0.5, 1.0, 1e200),
        lambda: sn.Servo(speed_limit_rad_s=1e-320),
    ],
)
def test_numbers_whose_consequences_are_not_finite_are_refused(make):
    with refused("magnitude"):
        make()


def test_nobody_is_told_to_join_root(monkeypatch):
    monkeypatch.setattr("grp.getgrgid", lambda _: SimpleNamespace(gr_name="root"))
    said = ports.why_forbidden("/dev/null")
    assert "usermod -aG root" not in said
    assert "udev" in said
