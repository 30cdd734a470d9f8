"""Check that the packages of the extra [video], which films need, are installed."""

from __future__ import annotations

from importlib.util import find_spec

from ...base.errors import BadInput


def need_extra() -> None:
    """Raise BadInput, with the command that installs them, if packages are missing."""
    packages = {"av": "av", "cv2": "opencv-python-headless"}  # Modules and their names on PyPI.
    missing = [package for module, package in packages.items() if find_spec(module) is None]
    if missing:
        raise BadInput(
            f"films and tags need {' and '.join(missing)}, not installed here: "
            "pip install 'serpenoid[video]'"
        )
