"""Practice at a desk: the words that work the treadmill, and whose truth is found."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration.conversations import Typist
from refusals import refused
from serpenoid import Session
from serpenoid.calibration.crawls.filmed import crawl_cells
from serpenoid.calibration.taking.new_session import default_setup
from serpenoid.calibration.taking.person.practice import (
    USUAL,
    drawn_truth,
    practice_seed,
    practice_setup,
    truth_in_words,
)
from serpenoid.calibration.taking.person.practice_treadmill import TreadmillTerminal, picture
from serpenoid.calibration.taking.steps import Step

SETUP = practice_setup(default_setup("practice"), 7)


def practised(*lines):
    typed = Typist(*lines)
    terminal = TreadmillTerminal(typed, SETUP, 7, Path("films"), lambda: [0.0] * 5, 50.0)
    return typed, terminal.room, terminal


def test_a_gait_is_run_and_filmed_on_level_ground_by_servos(tmp_path):
    """The film is taken in as a phone's; its joints are those of a servo, not ideal ones."""
    typed = Typist("crawl", "film", "(nobody)", "crawl", "film")
    setup = replace(SETUP, procedure=replace(SETUP.procedure, lambda_rad=(), gait_runs=1))
    terminal = TreadmillTerminal(typed, setup, 7, tmp_path / "films", lambda: [0.0] * 5)
    assert terminal.ask("", 1.0, lambda: None) is None  # no gait is to be run yet
    assert "  no gait is to be run at this step; `treadmill` lists the words" in typed.heard
    assert "  the robot is not on the belt" in typed.heard
    gait = setup.procedure.gaits[1]
    step = Step("gait 2.1", "gait", "", gait=gait)
    terminal.watch(Session(setup, ()), step)
    path = Path(terminal.ask("", 1.0, lambda: None))
    assert path.exists()
    timed = re.search(r"it crawled ([\d.]+) m in ([\d.]+) s", typed.heard)
    speed = float(timed[1]) / float(timed[2])
    cells = crawl_cells(np.loadtxt(path, delimiter=",", skiprows=1), gait)
    assert cells["speed_m_s"] == pytest.approx(speed, rel=0.05)
    assert terminal.world.robot.servo is not None


def test_steering_words_press_the_keys():
    typed, _, terminal = practised("left 3", "left 0.5", "right", "")
    typed.keys, pressed = {}, []
    terminal.keys = {w: lambda w=w: pressed.append(w) or w for w in ("left", "right")}
    assert terminal.ask("", 1.0, lambda: None) == ""
    assert pressed == ["left"] * 3 + ["right"]
    assert typed.keys == terminal.keys


def test_time_at_the_treadmill_is_the_dialogues_clock():
    """At 50 times the pace 0.4 s are 20 s: whoever waits so long is not told "too early"."""
    _, room, terminal = practised()
    before = terminal.clock_s()
    room.pass_time(20.0)
    assert terminal.clock_s() - before == pytest.approx(20.0)


def test_a_seed_is_a_truth_near_the_robot_of_2005():
    one, same, other = (drawn_truth(s) for s in (7, 7, 8))
    assert one == same
    assert one != other
    for name, usual in USUAL.items():
        assert 0.5 < getattr(one.ground, name) / usual < 2.0
    assert "ft0" in truth_in_words(one, "treadmill")
    assert abs(one.deck_rad) <= math.radians(0.2)


def test_a_session_of_practice_knows_its_seed_and_no_other_is_taken():
    assert SETUP.kind == "simulated"
    assert practice_seed(Session(SETUP, ())) == 7
    with refused("no session of practice"):
        practice_seed(Session(replace(SETUP, source="my treadmill"), ()))


def test_the_picture_has_no_robot_once_it_is_off():
    _, room, _ = practised()
    assert "#" not in picture(room)
    room.put()
    assert picture(room).count("O") >= 1
