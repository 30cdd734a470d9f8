"""The firmware keeps its limits of memory, time and pulse error on both chips under load."""

import pytest
from avr.budget import BOARDS, FLASH, MIN_UNTOUCHED_RAM, measure, memory

pytestmark = [pytest.mark.avr, pytest.mark.slow]


@pytest.mark.parametrize("name", BOARDS)
def test_budget_is_kept(firmware_elf, name):
    broken = [row for row in measure(name) if not row.is_kept]
    assert not broken


@pytest.mark.parametrize("output", ["servo", "pca9685"])
@pytest.mark.parametrize(("name", "joints"), [("uno", 8), ("mega", 12)])
def test_memory_suffices_for_the_largest_number_of_joints(firmware_elf, name, joints, output):
    flash, _, untouched, _ = memory(name, joints, output)
    assert flash <= FLASH[name]
    assert untouched >= MIN_UNTOUCHED_RAM
