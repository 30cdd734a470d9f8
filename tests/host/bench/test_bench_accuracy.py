"""The benchmark: limits of time, truth, times at equal error, files, defects that are counted."""

from __future__ import annotations

import math
import os
import signal
import time
from dataclasses import replace

import pytest
import serpenoid as sn
from serpenoid.base.checks import CHOICES
from serpenoid.bench import extremes, scenes
from serpenoid.bench.child_process import Limited
from serpenoid.bench.problems import problems, reference

PROBLEMS = {p.name: p for p in problems()}


def test_a_child_answers_fails_hangs_dies_and_leaves_ctrl_c_to_who_started_it() -> None:
    with Limited() as child:
        pid, note = child(5.0, os.getpid)
        assert not note
        os.kill(pid, signal.SIGINT)
        assert child(5.0, os.getpid) == (pid, "")
        assert child(5.0, math.sqrt, -1.0)[1].startswith("ValueError: ")
        assert child(0.5, math.factorial, 10**7) == (None, "HANG: stopped after 0.5 s")  # compiled
        assert child(0.01, time.sleep, 60) == (None, "HANG: stopped after 0.01 s")
        assert child(5.0, os._exit, 7) == (None, "CRASH: the process ended with status 7")
        assert child(5.0, abs, -3) == (3, "")


@pytest.mark.parametrize(
    "name", ["paper3", "paper3_k1e3", "paper6", "paper6_k1e3", "n50", "robot2005"]
)
def test_kept_end_states_are_those_of_the_core(name: str) -> None:
    """RK4 at 0.5 ms: order four leaves less than 1e-8 of each viscous scene that is not stiff."""
    problem = PROBLEMS[name]
    run = sn.simulate(replace(problem.scene, record_every=10**6, dt_s=5e-4, tolerance=1e-10))
    assert problem.error(problem.vector(run.state()), reference(problem)[0]) < 1e-8
    assert reference(problem)[1] < 1e-9


def test_extreme_scenes_meet_their_error_or_say_no() -> None:
    names = "cn/ct = 1e6", "mass 1e-6 kg", "hard stick", "k = 2.2e6, c = 1 at 1 ms"
    words = {}
    for problem in extremes.extremes():
        if problem.name not in names:
            continue
        exact = reference(problem)[0] if problem.name == "hard stick" else None
        for method in ("rk4", "nonsmooth"):
            try:
                word = extremes.outcome_of(problem, method, exact).outcome
            except sn.SerpenoidError as error:
                word = type(error).__name__
            words[problem.name, method] = word
    assert words["k = 2.2e6, c = 1 at 1 ms", "rk4"] == "StepTooLarge"
    assert words["mass 1e-6 kg", "rk4"] == "StepTooLarge"
    assert words["hard stick", "nonsmooth"] == "met"
    assert words["cn/ct = 1e6", "rk4"] == "no reference"


@pytest.mark.parametrize("formulation", CHOICES["formulation"])
def test_each_term_of_a_scene_runs(formulation: str) -> None:
    for scene in scenes.variants(formulation, 10).values():
        assert sn.simulate(scene).steps == 10
