"""The boards that a host test runs on: the virtual one, the simulated ELF, and real hardware."""

from __future__ import annotations

import pytest

BOARDS = ["virtual", pytest.param("simulated", marks=pytest.mark.avr), "hardware"]


@pytest.fixture(params=BOARDS)
def any_port(request: pytest.FixtureRequest) -> str:
    """Return the port of each board in turn; the hardware only where --port names it."""
    if request.param == "simulated":
        return request.getfixturevalue("simulated_board").port
    if request.param == "hardware":
        return request.getfixturevalue("hardware_port")
    return request.param


@pytest.fixture
def hardware_port(request: pytest.FixtureRequest) -> str:
    """Return the port of a real robot, or skip."""
    port = request.config.getoption("--port")
    if not port:
        pytest.skip("needs a real robot; name its port with --port=/dev/...")
    return port
