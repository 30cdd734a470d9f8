"""What all tests share: the boards, simulated and real; a busy machine; what CI may skip."""

import os
import signal
from collections.abc import Generator
from typing import TypeVar

import pytest
from hypothesis import HealthCheck, settings

pytest_plugins = ["avr.fixtures", "robot.patience", "robot.boards"]

settings.register_profile(
    "calm", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("calm")

# How somebody likes their terminal is nothing that tests may depend on.
for taste in ("COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "CLICOLOR_FORCE", "PYTHONWARNINGS"):
    os.environ.pop(taste, None)
os.environ["MPLBACKEND"] = "agg"

# What CI need not have; make installs all the rest.
OPTIONAL = (
    "needs a real robot",
    "needs x86",
    "needs Linux",
    "needs a system with",
)
Report = TypeVar("Report", pytest.TestReport, pytest.CollectReport)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--port", help="also test on the robot at this port; it will move")


def pytest_configure() -> None:
    """Let Ctrl-C reach the programs that tests start, even where the shell has it ignored."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def judged(report: Report) -> Report:
    """Return a report; one that skips what CI must run becomes a failure there."""
    if report.skipped and not hasattr(report, "wasxfail") and os.environ.get("CI") == "true":
        why = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        if not any(reason in why for reason in OPTIONAL):
            report.outcome, report.longrepr = "failed", f"CI must run this. {why}"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    return judged((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    return judged((yield))
