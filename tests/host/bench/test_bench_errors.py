"""What random runs say of their own error, held against the truth."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from click.testing import CliRunner
from serpenoid.bench import errors
from serpenoid.bench.errors import (
    DRY,
    IN_TIME,
    KINDS,
    STATES,
    Judged,
    coverage_rows,
    judge_class,
    random_scene,
    truth_scene,
)
from serpenoid.commands.main import cli
from serpenoid.model.errors import NotConverged
from serpenoid.periodic.steady import Steady, steady_gait
from serpenoid.simulation.judge import difference

SEED = 20261121


def misses(count: int) -> list[Judged]:
    """Return the runs that are further off than three times what they say, without a warning."""
    return [run for run in judge_class(count, SEED, lambda _: None) if not run.kept]


@pytest.fixture(scope="module")
def few() -> list[Judged]:
    return list(judge_class(1, SEED, lambda _: None))


def test_random_runs_know_how_far_they_are_off(few: list[Judged]) -> None:
    """One of every kind: of so few none may miss."""
    assert [run for run in few if not run.kept] == []
    assert list(dict.fromkeys(run.kind for run in few)) == list(KINDS)


def test_dry_kinds_are_dry_and_ratchets_ratchets(few: list[Judged]) -> None:
    for run in few:
        ground = run.scene.ground
        assert ground.smooth == (run.kind not in (*DRY, "dry_states", "ratchet_states"))
        assert ground.ratchet == run.kind.startswith("ratchet")


@pytest.mark.parametrize("kind", STATES)
def test_a_state_that_claims_too_little_is_a_miss(
    kind: str, few: list[Judged], monkeypatch
) -> None:
    """The same states, a thousandth faster than they are, at the estimates they had."""
    before = next(run for run in few if run.kind == kind)

    def wrong(*of: object, **how: object) -> Steady:
        found = steady_gait(*of, **how)
        return replace(found, chord_m_s=1.001 * found.chord_m_s, power_w=1.001 * found.power_w)

    monkeypatch.setattr(errors, "steady_gait", wrong)
    scene = before.scene
    state = errors.judge_state(kind, scene.robot, scene.ground, scene.gait, 1e-6)
    assert state is not None
    assert state.ratio > 10


@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "count"), [(IN_TIME, 60), (DRY, 20), (STATES, 20)])
def test_many_random_runs_know_how_far_they_are_off(kinds, count: int, monkeypatch) -> None:
    monkeypatch.setattr(errors, "KINDS", kinds)
    assert len(misses(count)) <= 0.01 * count * len(kinds)


def test_a_miss_is_counted_unless_warned_of(few: list[Judged]) -> None:
    low = replace(few[0], true=1.0, estimate=0.1, settled=True)
    assert not low.kept
    assert replace(low, settled=False).kept
    assert replace(low, estimate=0.4).kept
    assert not replace(low, true=math.nan).kept
    row = coverage_rows([low, replace(low, settled=False)])[-1]
    assert (row["unwarned_misses"], row["warned"], row["within_3"]) == (1, 1, 0.0)


def test_a_case_that_takes_too_long_is_given_up_and_counted() -> None:
    """A limp joint on a slope: its truth changes mode for ever, one in some hundred cases does."""
    told = list[str]()
    runs = list(judge_class(1, SEED, told.append, most_s=0.02))
    late = [run for run in runs if not run.judged]
    assert late
    assert all(run.kept for run in late)
    assert len([line for line in told if "given up after 0.02 s" in line]) == len(late)
    row = coverage_rows(runs)[-1]
    assert (row["given_up"], row["runs"]) == (len(late), len(runs) - len(late))
    errors.judge_random("viscous_states", np.random.default_rng(1))  # and the limit is off again


def test_the_command_publishes_the_coverage(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(errors, "KINDS", ("torque", "dry_servo"))
    done = CliRunner().invoke(cli, ["bench", "errors", "--runs", "1", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    lines = (tmp_path / "errors.csv").read_text().splitlines()
    assert lines[0].startswith("kind,runs,within_estimate,within_3")
    assert [line.split(",")[0] for line in lines[1:]] == ["torque", "dry_servo", "all"]
    assert lines[-1].startswith("all,2,")


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["torque", "servo", "faults", "dry_torque"])
def test_an_accuracy_asked_for_is_kept_or_refused(kind: str) -> None:
    """Dry ground included, where a motion may be chaos: then it is refused, by that name."""
    kept, refusals = 0, list[str]()
    for seed in range(12):
        rng = np.random.default_rng([SEED, seed])
        scene = replace(random_scene(kind, rng), method="auto", dt_s=1e-3, tolerance=1e-7)
        accuracy = float(10 ** rng.uniform(-6, -2))
        try:
            run = sn.simulate(scene, accuracy=accuracy)
        except NotConverged as refused:
            refusals.append(str(refused))
            continue
        grid = {"dt_s": run.scene.dt_s, "record_every": run.scene.record_every}
        truth = sn.simulate(replace(truth_scene(run.scene, 1e-13), **grid))
        assert difference(run, truth).size(scene.robot.body_length_m) <= accuracy
        kept += 1
    assert kept > 0
    assert all("chaotic" in text or "shorter run" in text for text in refusals), refusals
