"""The controller through its Python binding: its tables, and a board before its first boot."""

from __future__ import annotations

import pytest
from serpenoid._core import firmware


def test_the_tables_of_the_protocol_page_equal_those_of_the_board(
    request: pytest.FixtureRequest,
) -> None:
    page = (request.config.rootpath / "firmware" / "PROTOCOL.md").read_text()
    for word, number, cause, cure in firmware.ERRORS:
        assert f"| `{word}` | {number} | {cause} | {cure} |" in page
        assert ":" not in cause + cure  # serial plotters would draw text before a colon
    for name, (_, low, high, default) in {**firmware.SETTINGS, **firmware.TRIM}.items():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{name}` |"))
        for value in (low, high, default):
            assert f"{value:g}".replace("-", "−") in row
    assert f"fw={firmware.VERSION} protocol={firmware.PROTOCOL} " in page


def test_a_board_must_be_booted() -> None:
    with pytest.raises(RuntimeError, match="has not been booted"):
        firmware.Board().run(1.0)
