"""Shared by all tests: fixtures of simulated and real boards, settings, and skips allowed in CI."""

import os
import signal
from collections.abc import Generator
from typing import TypeVar

import pytest
from hypothesis import HealthCheck, settings

pytest_plugins = ["avr.fixtures", "robot.patience", "robot.boards"]

settings.register_profile(
    "repeatable", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("repeatable")

# Tests must not depend on a person's settings of the terminal.
for variable in ("COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "CLICOLOR_FORCE", "PYTHONWARNINGS"):
    os.environ.pop(variable, None)
os.environ["MPLBACKEND"] = "agg"

# Parts of the reasons for which a test may be skipped in CI; make installs all other tools.
ALLOWED_SKIPS = (
    "needs a real robot",
    "needs x86",
    "needs Linux",
    "needs a system with",
)
Report = TypeVar("Report", pytest.TestReport, pytest.CollectReport)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--port", help="also test on the robot at this port; it will move")


def pytest_configure() -> None:
    """Let Ctrl-C reach the programs that tests start, even if the shell ignores it."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def checked_skip(report: Report) -> Report:
    """Return the report; in CI a skip for any other reason becomes a failure."""
    if report.skipped and not hasattr(report, "wasxfail") and os.environ.get("CI") == "true":
        cause = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        if not any(reason in cause for reason in ALLOWED_SKIPS):
            report.outcome, report.longrepr = "failed", f"CI must run this. {cause}"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    return checked_skip((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    return checked_skip((yield))
