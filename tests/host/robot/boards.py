"""The boards that a host test runs on: the virtual one, the simulated ELF, and real hardware."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from serpenoid.commands.main import main

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


@pytest.fixture
def serpenoid(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str, str]]:
    """Return the command line in this process: (exit status, standard output, standard error)."""

    def run(*args: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["serpenoid", *args])
        capsys.readouterr()
        with pytest.raises(SystemExit) as left:
            main()
        said = capsys.readouterr()
        return int(left.value.code or 0), said.out, said.err

    return run
