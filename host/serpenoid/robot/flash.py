"""Build the firmware with PlatformIO and put it on a board."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path


def find_platformio() -> str | None:
    """Return the path of `pio`: on PATH, or beside this Python; None if there is none."""
    beside = Path(sys.executable).with_name("pio")
    return shutil.which("pio") or (str(beside) if beside.exists() else None)
