"""The packages that films need beside the package's own: the extra [video]."""

from __future__ import annotations

from importlib.util import find_spec

from ...base.errors import BadInput

NEEDED = {"av": "av", "cv2": "opencv-python-headless"}


def need_extra() -> None:
    """Raise BadInput where a package of the extra is missing."""
    missing = [package for name, package in NEEDED.items() if find_spec(name) is None]
    if missing:
        raise BadInput(
            f"films and tags need {' and '.join(missing)}, not installed here: "
            "pip install 'serpenoid[video]'"
        )
