"""What breaks a film's numbers without a word in its file: a cut, pictures held, a bent tag."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.errors import BadInput
from .fitting.frames import Track
from .instrument import Measured
from .result import Remark

Array = NDArray[np.float64]
# A line through four residuals on either side, up to the middle: what comes after less what was
# before. Noise of one frame counts 1.4 times, a smooth residual nearly nothing.
STEP = np.array([0.35, -0.05, -0.45, -0.85, 0.85, 0.45, -0.05, -0.35])
JOINTS_RAD, PATH_LINKS = math.radians(3.0), 0.05  # a smaller step is no cut
BESIDE_TYPICAL = 8.0  # times the median step of the film
BENT = 2.5  # times the typical residual of the other tags


def refuse_cut(measured: Measured, name: str) -> None:
    """Raise BadInput where joints and path jump from one frame to the next, and stay there."""
    fitted, t_s = measured.fitted, measured.track.t_s
    if len(t_s) <= len(STEP):
        return
    joints = _median(np.where(measured.held, fitted.joints_rest_rad, np.nan))
    known = fitted.path_weight > 0.3
    link_m = measured.bundle.camera.link_m
    path = np.abs(_steps(np.where(known, fitted.path_rest_m / link_m, np.nan)))
    far = np.fmax(_far(joints, JOINTS_RAD), _far(path, PATH_LINKS))
    worst = int(far.argmax())
    if far[worst] <= 1.0:
        return
    bend, way = np.nan_to_num([joints[worst], path[worst]])
    raise BadInput(
        f"{name}: the robot jumps at {t_s[worst + len(STEP) // 2]:.2f} s: joints by "
        f"{math.degrees(bend):.0f}°, its middle by {1e3 * way * link_m:.0f} mm beside its steady "
        "motion: the film is cut there, or pictures are missing that its times do not tell. Give "
        "a part without cuts, as the phone wrote it"
    )


def _median(joints: Array) -> Array:
    """Return the median of all joints' steps where most are known, else NaN."""
    steps = np.abs(_steps(joints))
    steps[np.isnan(steps).sum(axis=1) > steps.shape[1] // 2] = np.nan
    some = np.isfinite(steps).any(axis=1)
    out = np.full(len(steps), np.nan)
    out[some] = np.nanmedian(steps[some], axis=1)
    return out


def _steps(rest: NDArray[Any]) -> NDArray[Any]:
    """Return by how much residuals (frames, ...) step between the frames 3 and 4 of each eight."""
    count = len(rest) - len(STEP) + 1
    return np.asarray(sum(weight * rest[k : k + count] for k, weight in enumerate(STEP)))


def _far(steps: Array, least: float) -> Array:
    """Return steps beside what is a cut: above 1 for one."""
    if not np.isfinite(steps).any():
        return np.zeros(len(steps))
    return np.nan_to_num(steps / max(least, BESIDE_TYPICAL * float(np.nanmedian(steps))))


def bent_tags(track: Track) -> NDArray[np.bool_]:
    """Return which tags, (links,), are no flat squares: their corners fit far worse than others'.

    With fewer than four tags it is not clear which one is bent: none is named.
    """
    seen = np.asarray(np.isfinite(track.rest_px).any(axis=0))
    typical = np.full(len(seen), np.nan)
    typical[seen] = np.nanmedian(track.rest_px[:, seen], axis=0)
    bent = typical > BENT * np.nanmedian(typical)
    return bent if seen.sum() >= 4 and bent.sum() <= seen.sum() - 3 else np.zeros_like(bent)


def bent_remarks(bent: NDArray[np.bool_]) -> list[Remark]:
    """Return what to tell of tags that were left out."""
    return [
        Remark(
            "bent tag",
            f"tag {link + 1} is no flat square: half peeled off, wet or bent? It is left out; "
            "stick it flat and film again",
        )
        for link in np.flatnonzero(bent)
    ]
