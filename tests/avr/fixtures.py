"""Pytest fixtures for everything that runs on a simulated board; loaded by tests/conftest.py."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest
from avr.board import Board, wired
from avr.toolchain import ToolchainError, build_firmware, require


@pytest.fixture(scope="session")
def toolchain() -> None:
    """Skip with the reason where the firmware cannot be built; where CI=true fail instead."""
    try:
        require()
    except ToolchainError as error:
        if os.environ.get("CI") == "true":
            pytest.fail(str(error))
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def firmware_elf(toolchain: None) -> Callable[..., Path]:
    """Return a function from board name and joints to the ELF, built as PlatformIO does."""
    return cache(build_firmware)


@pytest.fixture
def start(firmware_elf: Callable[..., Path]) -> Iterator[Callable[..., Board]]:
    """Return a function that powers a simulated board: start("uno", eeprom=None, joints=5).

    output="pca9685": with that driver at its two wires, and the pin that enables it watched.
    """
    boards: list[Board] = []

    def power_on(
        board: str = "uno", eeprom: bytes | None = None, joints: int = 5, output: str = "servo"
    ) -> Board:
        usual = (joints, output) == (5, "servo")
        elf = firmware_elf(board) if usual else firmware_elf(board, joints, output)
        boards.append(wired(elf, board, joints, output))
        if eeprom is not None:
            boards[-1].eeprom = eeprom
        return boards[-1]

    yield power_on
    for board in boards:
        board.close()
