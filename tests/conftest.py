"""What all tests share: the boards, simulated and real."""

import pytest

pytest_plugins = ["avr.fixtures", "robot.boards"]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--port", help="also test on the robot at this port; it will move")
