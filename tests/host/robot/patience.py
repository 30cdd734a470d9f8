"""A clock that leaves out what its process slept, so that a busy machine makes nobody late."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import pytest
from serpenoid.robot.recording import recorder
from serpenoid.robot.wire import link, virtual

MOST_S = 0.1  # that may pass from one look to the next; whoever waits looks far more often
LONG_S = 60.0  # for what happens at once unless something is wrong


class PatientClock:
    """Run as time.monotonic does, but for stretches in which nobody looked: these do not count."""

    def __init__(self) -> None:
        self._looking = threading.Lock()
        self._now_s = self._looked_s = time.monotonic()

    def __call__(self) -> float:
        """Return the time, in s."""
        with self._looking:
            looked_s = time.monotonic()
            self._now_s += min(looked_s - self._looked_s, MOST_S)
            self._looked_s = looked_s
            return self._now_s


clock = PatientClock()


def until(condition: Callable[[], object], most_s: float = LONG_S) -> bool:
    """Wait for a condition; tell whether it came to be."""
    end_s = time.monotonic() + most_s
    while not (found := condition()) and time.monotonic() < end_s:
        time.sleep(0.005)
    return bool(found)


@pytest.fixture(scope="session", autouse=True)
def patient_boards() -> Iterator[None]:
    """Let the boards and hosts of this process go by the patient clock; disks may be slow."""
    patient = SimpleNamespace(monotonic=clock, sleep=time.sleep)
    with pytest.MonkeyPatch.context() as patch:
        for module in (link, virtual):
            patch.setattr(module, "time", patient)
        patch.setattr(recorder, "DISK_S", LONG_S)
        yield
