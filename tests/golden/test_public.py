"""What users see by name stays: a change of it is a line in CHANGELOG.md."""

from __future__ import annotations

import difflib

import pytest
from golden import make_public
from golden.make_public import is_going, promises, without

CURE = """
What users see has changed. If that is meant: write a line in CHANGELOG.md, run
`python tests/golden/make_public.py`, and commit public.txt and going.txt with both. If not, put
it back.
"""
TEXT = """# Commands
serpenoid fit
    --method: joint|robust|naive, default joint
    --json: boolean

# Python
sn.fit(session, *, method='joint')
sn.fits
"""
LEFT = """# Commands
serpenoid fit
    --method: joint|naive, default joint

# Python
sn.fit(session)
sn.fits
"""
TO_GO = [
    "Commands: serpenoid fit --method robust",
    "Commands: serpenoid fit --json",
    "Python: sn.fit *",
    "Python: sn.fit method='joint'",
]


def test_what_users_see_is_as_the_file_has_it(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    kept, now = promises(make_public.PATH.read_text(encoding="utf-8")), make_public.public()
    named, going = promises(now), make_public.going()
    left = [name for name in named if not is_going(name, going)]
    changes = list(difflib.unified_diff(kept, left, "kept", "now", "", "", 0, ""))
    stale = [entry for entry in going if not any(is_going(name, [entry]) for name in named)]
    changes += [f"gone, but still in going.txt: {entry}" for entry in stale]
    if changes:
        pytest.fail(CURE + "\n".join(changes), pytrace=False)


def test_a_promise_that_goes_is_a_line_or_a_word_of_it() -> None:
    assert without(TEXT, TO_GO) == LEFT
    assert [name for name in promises(TEXT) if not is_going(name, TO_GO)] == promises(LEFT)
    assert without(TEXT, ["Python"]) == TEXT.split("# Python", maxsplit=1)[0]
