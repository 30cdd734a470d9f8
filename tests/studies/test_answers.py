"""A sample of the fixed answers is as it was; studies/answers.py holds all of them."""

from __future__ import annotations

import json

import pytest
from answers import ANSWERS, KINDS, answer_of, changes, names

SLOW = {"bench-test", "fit-crawls", "predict", "derivatives", "film", "advice", "band"}
SAMPLE = {name for kind in KINDS.keys() - SLOW for name in names([kind])[:1]}
KEPT = json.loads(ANSWERS.read_text())
CURE = (
    "; if that is meant, run studies/answers.py --write and say in the commit what changed and why"
)


def test_every_case_has_its_answer() -> None:
    assert list(KEPT) == names([])


@pytest.mark.parametrize("name", sorted(SAMPLE))
def test_an_answer_is_within_its_claim(name, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    changed = [" | ".join(row) for row in changes(name, KEPT[name], answer_of(name))]
    assert not changed, "\n".join(changed) + CURE


def test_a_change_beyond_the_claims_is_told_and_a_cheaper_optimum_is_none() -> None:
    before = {"speed_m_s": [1.0, 1e-7], "least power_w": [2.0, 1e-3], "verdict": "agrees"}
    assert not list(changes("steady-dry 0", before, before))
    cheaper = before | {"least power_w": [1.0, 1e-3], "speed_m_s": [1.0 + 1.9e-7, 1e-7]}
    assert not list(changes("optimum-dry 0", before, cheaper))
    for worse in (
        {"speed_m_s": [1.0 + 2.1e-7, 1e-7]},
        {"speed_m_s": [1.0, 2e-6]},
        {"least power_w": [2.1, 1e-3]},
        {"verdict": "too fast"},
    ):
        [row] = changes("steady-dry 0", before, before | worse)
        assert row[1] in worse
