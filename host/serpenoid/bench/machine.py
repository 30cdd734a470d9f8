"""What a timing depends on: the processor, the compiler, and the versions of what was timed."""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path

from .. import _core

PACKAGES = ("serpenoid", "numpy", "scipy")


def cpu() -> str:
    """Return the processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def compiler() -> str:
    """Return the name and version of the compiler that built the core."""
    return _core.compiler


def versions() -> dict[str, str]:
    """Return the versions of Python and of each package in the comparison."""
    return {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}}
