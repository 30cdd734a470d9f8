"""What all tests share: the boards, simulated and real."""

import signal

import pytest

pytest_plugins = ["avr.fixtures", "robot.boards", "robot.joints_board", "robot.patience"]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--port", help="also test on the robot at this port; it will move")


def pytest_configure() -> None:
    """Let Ctrl-C reach the programs that tests start, even where the shell has it ignored."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
