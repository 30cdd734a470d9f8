"""The boards that a host test runs on: the virtual one, the simulated ELF, and real hardware."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from avr.board import Board
from robot.fake_board import GAIT, FakeBoard, keep_line
from serpenoid.base.errors import RobotLost
from serpenoid.robot import RobotBoard
from serpenoid.robot.wire.virtual import LEAST_S, STEP_S

BOARDS = ["virtual:fast", pytest.param("simulated", marks=pytest.mark.avr), "hardware"]


class SimulatedLink:
    """A wire to the simulated ELF in its own time, which passes in read() alone, however slowly."""

    lockstep, name = True, "simulated"

    def __init__(self, board: Board):
        self.board = board
        board.reset("external")

    def now_s(self) -> float:
        """Return the board's time."""
        return self.board.time_s

    def read(self, timeout_s: float) -> bytes:
        """Let time pass and return what the board said in it."""
        self.board.run(max(LEAST_S, min(timeout_s, STEP_S)))
        if not self.board.runs:
            raise RobotLost("the simulated board crashed")
        return self.board.read()

    def write(self, data: bytes) -> None:
        """Put bytes on the wire to the board, at its pace."""
        self.board.send(data)

    def close(self) -> None:
        """Do nothing: there is no port to give back."""


@pytest.fixture
def simulated(start: Callable[..., Board], monkeypatch: pytest.MonkeyPatch) -> Board:
    """Put a simulated Uno behind every port that a RobotBoard opens; opening it resets it."""
    board = start("uno")
    monkeypatch.setattr("serpenoid.robot.robot.open_link", lambda _: SimulatedLink(board))
    return board


@pytest.fixture(params=BOARDS)
def any_port(request: pytest.FixtureRequest) -> str:
    """Return the port of each board in turn; the hardware only where --port names it."""
    if request.param == "simulated":
        request.getfixturevalue("simulated")
    return _port_of(request)


@pytest.fixture(params=["virtual", "hardware"])
def any_live_port(request: pytest.FixtureRequest) -> str:
    """Return the port of each board that a process of its own can open."""
    return _port_of(request)


def _port_of(request: pytest.FixtureRequest) -> str:
    return (
        request.getfixturevalue("hardware_port") if request.param == "hardware" else request.param
    )


@pytest.fixture
def hardware_port(request: pytest.FixtureRequest) -> str:
    """Return the port of a real robot, or skip."""
    port = request.config.getoption("--port")
    if not port:
        pytest.skip("needs a real robot; name its port with --port=/dev/...")
    return port


@pytest.fixture
def crawling() -> Iterator[tuple[FakeBoard, RobotBoard]]:
    """Drive a board behind a pseudo-terminal, and give both; it tells the truth at the end."""
    with FakeBoard() as fake, RobotBoard(fake.port) as robot:
        robot.gait(GAIT)
        yield fake, robot
        fake.to_host = keep_line
