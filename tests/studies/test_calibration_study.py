"""The studies of the calibration, made small: intervals cover, verdicts on gross faults hold."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from coverage_treadmill import (
    CASES,
    GAIT,
    STUDY,
    WHOLE,
    DrivenTable,
)
from serpenoid import Ground
from serpenoid.calibration.speeds import speed
from serpenoid.calibration.taking.new_session import default_setup
from speed_table import SpeedTable
from study import Study
from verdicts import (
    FAULTS,
    MORE,
    TrueSpeeds,
    counted,
    words,
)

ROBOT = default_setup("test").robot
NAMES = ("ct", "cn", "ft0", "fn0", "speed")


def _pair(case, seed, number, world):
    return case, seed + number, world


def test_the_runner_runs_every_session_of_every_case():
    def rows(case, results):
        return [(case, results)]

    study = Study(("a", "b"), len, _pair, rows, lambda case: 1 if case == "a" else 5)
    expected = {"a": [("a", 7 + k, 2) for k in range(12)], "b": [("b", 7, 2), ("b", 8, 2)]}
    assert dict(study.run(12, 7, lambda _: None)) == expected


@pytest.fixture(scope="module")
def table():
    return SpeedTable(ROBOT, GAIT, points=256)


@pytest.fixture(scope="module")
def driven(table):
    return DrivenTable(ROBOT, table, 16, points=256)


def test_the_table_is_the_model(table):
    exact = speed(ROBOT, Ground.whole_body(6, *WHOLE), GAIT)
    assert table(WHOLE[None])[0] == pytest.approx(exact, rel=0.03)


@pytest.mark.slow
def test_intervals_cover_95_percent_of_320_sessions(table, driven):
    """Of such samples, 1 in 80 fails where 95 % is true, and 89 in 100 where 90 % is."""
    cases = tuple(c for c in CASES if len(c.lambdas_deg) == 1)
    found = replace(STUDY, cases=cases, world=lambda _: (table, driven)).run(80, 1, print)
    shares = np.array([[getattr(case, name) for name in NAMES] for case in found])
    assert ((shares.mean(axis=0) > 0.92) & (shares.mean(axis=0) < 0.985)).all(), shares


@pytest.fixture(scope="module")
def verdicts():
    names = ("nothing", "ft0 +40%", "amplitude -30%", "tape -20%")
    faults = tuple(f for f in FAULTS if f.name in names)
    setup = default_setup("test")
    true = TrueSpeeds(setup.robot, setup.procedure.gaits, faults, servos=1)
    found = [words(faults, 2, 0, true)]
    return [dataclasses.asdict(counted(f, found)) for f in faults]


@pytest.mark.slow
def test_verdicts_on_gross_faults_are_right(verdicts):
    counts = {row["fault"]: row["counts"] for row in verdicts}
    assert counts["nothing"]["agrees"] == 1
    # servos that nobody knows may hide one of both, never both
    assert counts["ft0 +40%"]["friction"] + counts["ft0 +40%"][MORE] == 1
    assert counts["amplitude -30%"]["amplitude"] + counts["amplitude -30%"][MORE] == 1
    assert counts["tape -20%"]["neither"] + counts["tape -20%"]["agrees"] == 1  # servos hide it
