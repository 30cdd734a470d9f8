"""Every mutant still applies to the tree, and the list of those that died grows only."""

from __future__ import annotations

from mutants import killed, mutants

LEAST_KILLED = 56


def test_every_mutant_still_applies_and_is_named_once() -> None:
    listed = mutants()
    objections = [objection for mutant in listed if (objection := mutant.objection())]
    assert not objections, "\n".join(objections) + "\nstudies/mutants.py says how to renew one"
    assert len({mutant.name for mutant in listed}) == len(listed) == 66
    assert all(mutant.old != mutant.new for mutant in listed)


def test_no_fewer_die_than_before() -> None:
    died = killed()
    assert set(died) <= {mutant.name for mutant in mutants()}
    assert len(died) == len(set(died)) >= LEAST_KILLED
