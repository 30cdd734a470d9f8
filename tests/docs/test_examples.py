"""Each public name has an example in its docstring, and the example says what happens."""

from __future__ import annotations

import doctest
from pathlib import Path

import pytest
import serpenoid as sn

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", sn.__all__)
def test_example_of_a_public_name(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "calibration_data").symlink_to(ROOT / "calibration_data")
    monkeypatch.chdir(tmp_path)
    text = getattr(sn, name).__doc__
    example = doctest.DocTestParser().get_doctest(text, {"sn": sn}, name, None, 0)
    assert example.examples
    printed: list[str] = []
    failed, _ = doctest.DocTestRunner(verbose=False).run(example, out=printed.append)
    assert not failed, "".join(printed)
