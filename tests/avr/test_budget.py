"""The firmware keeps its budget of memory, time and pulse error on both chips, with serial busy."""

import pytest
from avr.budget import BOARDS, measure

pytestmark = [pytest.mark.avr, pytest.mark.slow]


@pytest.mark.parametrize("name", BOARDS)
def test_budget_is_kept(firmware_elf, name):
    broken = [row for row in measure(name) if not row.kept]
    assert not broken
