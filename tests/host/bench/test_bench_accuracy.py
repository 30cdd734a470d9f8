"""The accuracy benchmark's parts: limits, truth, times at equal error, files, the table."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest
import serpenoid as sn
from refusals import refused
from serpenoid.bench.accuracy import equal_error
from serpenoid.bench.accuracy import measure as accuracy
from serpenoid.bench.accuracy.equal_error import table
from serpenoid.bench.accuracy.measure import Effort, Row
from serpenoid.bench.child_process import Crashed, Failed, Limited, Overran
from serpenoid.bench.problems import problems, reference
from serpenoid.bench.rows import read_rows, renew_table, write_rows

ROOT = Path(__file__).parents[3]
PROBLEMS = {p.name: p for p in problems()}


def test_a_child_answers_fails_hangs_and_dies() -> None:
    with Limited() as child:
        assert child(5.0, math.sqrt, 2.0) == math.sqrt(2.0)
        with pytest.raises(Failed, match="ValueError"):
            child(5.0, math.sqrt, -1.0)
        with pytest.raises(Overran, match=r"after 0\.5 s"):
            child(0.5, math.factorial, 10**7)  # compiled, and long
        with pytest.raises(Crashed, match="status 7"):
            child(5.0, os._exit, 7)
        assert child(5.0, abs, -3) == 3


def test_a_child_that_sleeps_is_stopped() -> None:
    with Limited() as child:
        assert child(5.0, abs, 0) == 0  # it is up
        with pytest.raises(Overran, match="on the wall"):
            child(0.01, time.sleep, 60)


def test_a_child_leaves_ctrl_c_to_who_started_it_and_starts_in_any_thread() -> None:
    before = signal.getsignal(signal.SIGINT)
    answers: list[bool] = []

    def work() -> None:
        with Limited() as child:
            pid = child(20.0, os.getpid)
            os.kill(pid, signal.SIGINT)
            answers.append(child(20.0, os.getpid) == pid)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert answers == [True]
    assert signal.getsignal(signal.SIGINT) is before


def test_ratios_are_of_the_best_on_either_side() -> None:
    def row(method: str, time_s: float) -> Row:
        return Row("paper6", method, "", "dt_s", 1.0, 1e-7, time_s, simulated_s=10.0)

    times = {"serpenoid rk4": 3.0, "serpenoid x": 1.0, "SciPy A": 4.0, "SciPy B": 2.0}
    rows = [row(method, time_s) for method, time_s in times.items()]
    rows.append(Row("paper6", "serpenoid y", "", "dt_s", 1.0, note="no"))
    line = next(x for x in equal_error.headline(rows) if x["error"] == 1e-6)
    assert (line["ours"], line["peer"], line["ratio"]) == ("serpenoid x", "SciPy B", 2.0)
    assert "| serpenoid x | 100 |" in equal_error.table(rows)
    assert "serpenoid y" not in equal_error.table(rows)


@pytest.mark.parametrize(
    "name", ["paper3", "paper3_k1e3", "paper6", "paper6_k1e3", "n50", "robot2005"]
)
def test_kept_end_states_are_those_of_the_core(name: str) -> None:
    """RK4 at 0.5 ms: order four leaves less than 1e-8 of each viscous scene that is not stiff."""
    problem = PROBLEMS[name]
    dry = {"method": "nonsmooth", "tolerance": 1e-10}
    how = {"dt_s": 5e-4} if problem.ground.smooth else dry
    run = sn.simulate(problem.scene(start=problem.start, record_every=10**6, **how))
    assert problem.error(problem.vector(run.state()), reference(problem).end) < 1e-8
    assert reference(problem).known_to < 1e-9


def test_a_reference_of_another_problem_is_refused() -> None:
    problem = PROBLEMS["paper3"]
    changed = replace(problem, duration_s=11.0)
    with refused("another problem"):
        reference(changed)


@pytest.mark.slow
def test_a_measured_scene_to_files_and_back(tmp_path: Path) -> None:
    effort = Effort(("paper3",), rounds=1, limit_s=1.0, budget_s=1.0)
    rows = accuracy.run(effort, lambda _: None)
    rk4 = [row for row in rows if row.method == "serpenoid rk4" and row.error is not None]
    assert len(rk4) >= 2
    assert rk4[0].error / rk4[1].error > 30  # order four between 10 ms and 3 ms: 123
    assert all(row.note for row in rows if row.error is None)
    write_rows(tmp_path / "a.csv", rows, {"cpu": "any"})
    assert read_rows(tmp_path / "a.csv", Row) == rows
    assert (tmp_path / "a.csv").read_text().splitlines()[0].endswith(",note,cpu")


def test_the_table_of_the_documentation_is_that_of_the_kept_measurement(tmp_path: Path) -> None:
    page = ROOT / "docs" / "benchmarks.md"
    copy = tmp_path / "page.md"
    copy.write_text(page.read_text())
    renew_table(copy, "accuracy", table(read_rows(ROOT / "host/docs/accuracy.csv", Row)))
    assert copy.read_text() == page.read_text()
    copy.write_text("no markers")
    with refused("once each"):
        renew_table(copy, "accuracy", "")
