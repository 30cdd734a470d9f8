"""The firmware keeps its budget of memory, time and pulse error on both chips, with serial busy."""

import pytest
from avr.budget import BOARDS, FLASH, LEAST_RAM, measure, memory

pytestmark = [pytest.mark.avr, pytest.mark.slow]


@pytest.mark.parametrize("name", BOARDS)
def test_budget_is_kept(firmware_elf, name):
    broken = [row for row in measure(name) if not row.kept]
    assert not broken


@pytest.mark.parametrize("output", ["servo", "pca9685"])
@pytest.mark.parametrize(("name", "joints"), [("uno", 8), ("mega", 12)])
def test_the_most_joints_that_a_board_takes_leave_it_memory(firmware_elf, name, joints, output):
    flash, _, left, _ = memory(name, joints, output)
    assert flash <= FLASH[name]
    assert left >= LEAST_RAM
