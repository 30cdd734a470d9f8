"""What users see by name stays: a change of it is a line in CHANGELOG.md."""

from __future__ import annotations

import difflib

import pytest
from golden import make_public

CURE = """
What users see has changed. If that is meant: write a line in CHANGELOG.md, run
`python tests/golden/make_public.py`, and commit public.txt with both. If not, put it back.
"""


def test_what_users_see_is_as_the_file_has_it(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    stored = make_public.PATH.read_text(encoding="utf-8").splitlines()
    changes = difflib.unified_diff(stored, make_public.public().splitlines(), "kept", "now", n=0)
    if text := "\n".join(changes):
        pytest.fail(CURE + text, pytrace=False)
