"""Checks of films in one table: each has a measure, limits, and a message.

A check adds a remark to the film's results, or refuses the film with a message on what to do.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import BadInput
from ..base.vectors import columns
from ..model.gait import Gait
from .arrays import Array
from .instrument import Measured, held_joints
from .made_gait import gait_doubt, measured_gait
from .result import FilmedRun, Remark
from .seeing.watch import Watched

MOVED_REFUSE = 0.06  # Largest allowed shift of the floor, in sides of a tag.
PHASE_RAD = math.radians(45.0)  # Phase error of a joint beyond that of any servo in order.


@dataclass(frozen=True)
class Check:
    """A check of a film, or of what was measured in it.

    stage: name of the stage of the measurement after which it is done: "seen", "placed", "fitted",
    "followed", "moved" or "servos". measure: function of the stage's result that returns a number
    or True; above `warn` it gives a remark with this name, above `refuse` the film is refused. A
    quantity with a lower limit has a minus, as has its limit. words: function of the stage's result
    and the number that returns the message.
    """

    stage: str
    name: str
    measure: Callable[[Any], float]
    words: Callable[[Any, float], str]
    refuse: float = math.inf
    warn: float = math.inf


def run_checks(stage: str, subject: Any) -> list[Remark]:
    """Return the remarks of a stage's checks on its result; raises BadInput if one refuses it."""
    remarks = []
    for check in CHECKS:
        value = float(check.measure(subject)) if check.stage == stage else -math.inf
        if value > check.refuse:
            raise BadInput(check.words(subject, value))
        if value > check.warn:
            remarks.append(Remark(check.name, check.words(subject, value)))
    return remarks


def _side_px(w: Watched) -> float:
    return float(np.nanmedian(w.sightings.side_px))


def _camera_moved(w: Watched) -> float:
    """Return the largest shift of the floor less four sigmas, in sides of a tag; at least 0."""
    shifts = [] if w.ground.plain else w.ground.shifts
    distances_px = [math.hypot(x, y) - 4.0 * sigma for _, x, y, sigma in shifts]
    return max([0.0, *distances_px]) / _side_px(w)


def _camera_words(w: Watched, _: float) -> str:
    times, x, y, _sigma = np.array(w.ground.shifts).T
    distances_px = np.hypot(x, y)
    when = times[np.argmax(distances_px > 0.5 * distances_px.max())]
    return (
        f"the camera moved by {distances_px.max():.1f} px, from {when:.1f} s on; more than "
        f"{MOVED_REFUSE * _side_px(w):.1f} px are refused. Put the phone on a tripod, switch "
        "stabilisation off, touch nothing while it films"
    )


def blur_factor(w: Watched) -> float:
    """Return the factor of the standard uncertainties for blur: 1 or 2.5."""
    min_px, min_cells = 1.0, 0.2  # Widths of a blurred edge, in pixels and in cells of the tag.
    blurred = np.nanquantile(w.edge_px, 0.9) > min_px and _edge_cells(w) > min_cells
    # The factor is the rms of error over sigma in rendered films with 1/30 s exposure, 25 ms
    # readout, and the camera 48 deg aslant.
    return 2.5 if blurred else 1.0


def _edge_cells(w: Watched) -> float:
    """Return the 90 % quantile of the widths of edges, in cells of a tag."""
    return float(np.nanquantile(w.edge_px / (w.sightings.side_px / 6), 0.9))


def _distances(centres: Array) -> Any:
    """Return the mean distances of neighbouring tags, m, (links - 1,), given (frames, links, 2).

    They are masked if two tags are never seen together.
    """
    distances = np.linalg.norm(np.diff(centres, axis=1), axis=-1)
    return np.ma.masked_invalid(distances).mean(axis=0)


def widened_sigmas(w: Watched, m: Measured) -> Array:
    """Return the standard uncertainties of a film's numbers, in the order of `Motion.numbers`.

    They are increased for blur, for a camera that moved, and for links and tags that disagree. A
    floor that shifts by s in the middle of a film of length T changes a line's slope by 1.5 s / T.
    """
    camera, speed_m_s = m.bundle.camera, max(m.motion.speed_m_s, 1e-9)
    drift_m_s = 1.5 * _camera_moved(w) * camera.side_m / np.ptp(m.track.t_s)
    turn_rad_s = drift_m_s / (camera.links * camera.link_m)
    more = [drift_m_s / speed_m_s, np.hypot(drift_m_s, m.bundle.scale_off * speed_m_s), turn_rad_s]
    sigmas = blur_factor(w) * m.sigmas
    sigmas[-3:] = np.hypot(sigmas[-3:], more)  # direction, speed, turn
    return sigmas


Filmed = tuple[FilmedRun, Gait | None]  # The measured motion, and the commanded gait.


def _shifts(filmed: Filmed) -> Array:
    """Return the phase error of each joint, rad, (joints,)."""
    return np.array(measured_gait(*filmed).joint_shift_rad)


def _shift_words(filmed: Filmed, _: float) -> str:
    lags = _shifts(filmed)
    joints = [
        f"joint {k + 1} is {math.degrees(lags[k]):+.0f}°"
        for k in np.flatnonzero(np.abs(lags) > PHASE_RAD)
    ]
    return (
        f"{', '.join(joints)} out of step with the others: does the servo turn the wrong way (set "
        "its trim's sense to the other sign), or are two plugs swapped? Mend it, and film again"
    )


def _centres(filmed: Filmed) -> tuple[Array, Array]:
    """Return each joint's error of centre, rad, and its ratio to the limit, (joints,) each."""
    run, gait = filmed
    offset, sigma = columns(run.joints, "offset_rad", "offset_sigma_rad")
    excess = offset - (gait.offset_rad if gait else 0.0)
    # An error of 1 degree is worth a correction of the trim.
    return excess, np.abs(excess) / np.maximum(math.radians(1.0), 2 * sigma)


def _centre_words(filmed: Filmed, _: float) -> str:
    excess, ratio = _centres(filmed)
    off_deg = np.degrees(excess)
    return "; ".join(
        f"joint {k + 1} swings about {off_deg[k]:+.1f}° off its centre: move its trim by "
        f"{-off_deg[k]:+.1f}°"
        for k in np.flatnonzero(ratio > 1)
    )


CHECKS = (
    Check(
        "seen", "strangers", lambda w: max(w.strangers.values(), default=0) / len(w.sightings.t_s),
        lambda w, _: f"shows tag {w.strangers.most_common(1)[0][0] + 1}, but the robot has "
        f"{w.sightings.links} links: another robot? If it is this one, give its number of links "
        "with --set links=...",
        refuse=0.2,  # Share of the frames.
    ),
    Check(
        "seen", "no tags", lambda w: 1 - w.sightings.visible.any(axis=1).mean(),
        lambda w, _: f"no tag is seen in {len(w.sightings.t_s)} frames; print ours with `serpenoid "
        "video tags`, with their white rim, at least 25 px a side in the film. AprilTags, other "
        "ArUco tags, the mirrored pictures of selfie cameras, and numbers that are seen twice in a "
        "picture do not count",
        refuse=0.96,  # Share of the frames; in 1 of 50 a pattern of the floor looks like a tag.
    ),
    Check(
        "seen", "few frames", lambda w: -(w.sightings.visible.sum(axis=1) > 1).sum(),
        lambda w, value: f"only {-value:.0f} of {len(w.sightings.t_s)} frames show two tags or "
        "more, 10 are needed; film two periods or more, go nearer, add light, and keep the whole "
        "robot in the picture",
        refuse=-10,
    ),
    Check("seen", "camera", _camera_moved, _camera_words, MOVED_REFUSE, warn=0.015),
    Check(
        "seen", "floor", lambda w: w.ground.plain,
        lambda w, _: "the floor shows too little to check whether the camera stood still; lay "
        "something printed beside the track, or add light",
        warn=0,
    ),
    Check(
        "seen", "small", lambda w: -_side_px(w),
        lambda w, value: f"the tags are {-value:.0f} px wide; the promised accuracy needs 33 px or "
        "more: go nearer or print larger. σ of phases and rate are up to 1.7 times too small",
        warn=-20,
    ),
    Check(
        "seen", "blur", blur_factor,
        lambda w, factor: f"the tags' edges are {_edge_cells(w):.2f} cells wide while they move: "
        f"add light or shorten the exposure; all σ are taken {factor:g} times as wide",
        warn=1,
    ),
    Check(
        "seen", "slow motion",
        lambda w: bool(w.film.capture) and (w.film.capture.stated or w.film.time_scale != 1.0),
        lambda w, _: w.film.capture.in_words(),
        warn=0,
    ),
    Check(
        "placed", "order", lambda centres: _distances(centres).max() / _distances(centres).min(),
        lambda centres, _: f"tag {_distances(centres).argmax() + 1} and the next one are no "
        "neighbours; number 1 belongs on the tail, then 2, 3, ...: put them on anew",
        refuse=1.6,  # Ratio of the longest to the shortest distance of neighbours.
    ),
    Check(
        "fitted", "scale", lambda b: b.scale_off,
        lambda b, excess: f"if the links are {1e3 * b.camera.link_m:.1f} mm long, the tags are "
        f"{1e3 * b.camera.side_m:.1f} mm wide, not {1e3 * b.side_m:.1f} mm: either the links have "
        "another length or the print another scale; measure both, and give --set link_length_m=... "
        f"or --tag-mm. Until then σ of all lengths and speeds includes {excess:.1%}; more than "
        "8 % is refused",
        refuse=0.08,
        warn=0,
    ),
    Check(
        "followed", "hidden joint", lambda track: 1 - held_joints(track).mean(axis=0).min(),
        lambda track, hidden: f"joint {held_joints(track).mean(axis=0).argmin() + 1} can be "
        f"measured in {1 - hidden:.0%} of the frames: a tag beside it is hidden or out of the "
        "picture. 15% are needed; keep the whole robot in the picture",
        refuse=0.85,  # Share of frames without the joint; with more, no sine can be fitted.
    ),
    Check(
        "moved", "still", lambda m: -m.motion.amplitude_rad.max(),
        lambda m, _: "no joint moves by more than 1°: the robot does not crawl, or its servos have "
        "no power",
        refuse=-math.radians(1),
    ),
    Check(
        "moved", "periods",
        lambda m: -m.motion.omega_rad_s * np.ptp(m.track.t_s) / math.tau,
        lambda m, value: f"shows {-value:.2f} periods of "
        f"{math.tau / m.motion.omega_rad_s:.2g} s; at least 1.5 are needed, two or more are "
        "better: film longer",
        refuse=-1.5,
    ),
    Check(
        "moved", "no sine",
        lambda m: np.average(m.motion.joint_residual_rad**2, weights=m.joint_mask) ** 0.5
        / m.motion.amplitude_rad.mean(),
        lambda m, share: f"the joints deviate from sines by {share:.0%} of the amplitude: did the "
        "robot start, stop or change its gait in the film? Cut those parts off",
        warn=0.1,
    ),
    Check("servos", "phase", lambda f: np.abs(_shifts(f)).max(), _shift_words, warn=PHASE_RAD),
    Check("servos", "centre", lambda f: _centres(f)[1].max(), _centre_words, warn=1),
    Check("servos", "gait", lambda f: gait_doubt(*f) != "", lambda f, _: gait_doubt(*f), warn=0),
)  # fmt: skip
