"""A page seen by a headless Chromium: what its script left in the document, and a picture of it."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]


def chromium() -> str:
    found = shutil.which("chromium") or shutil.which("google-chrome")
    if found is None and os.environ.get("CI"):
        pytest.fail("CI needs chromium: make test-slow installs it")
    return found or pytest.skip("needs chromium")


def document(url: str, width: int = 1100) -> str:
    return _run(url, width, "--dump-dom")


def picture(url: str, folder: Path, width: int = 1100) -> np.ndarray:
    """Return the page as pixels, (height, width, RGB) from 0 to 1."""
    import matplotlib.image

    path = folder / f"page{width}.png"
    _run(url, width, f"--screenshot={path}")
    return matplotlib.image.imread(path)[:, :, :3]


def _run(url: str, width: int, action: str) -> str:
    done = subprocess.run(
        [chromium(), *FLAGS, f"--window-size={width},900", "--virtual-time-budget=3000", action,
         url],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    return done.stdout
