"""What can be wrong with a film: one table of checks, each with its measure, words and limits.

A check warns, which is a remark beside the film's numbers, or refuses the film with the cure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import BadInput
from ..model.gait import Gait
from .arrays import Array
from .instrument import HELD_SHARE, Measured, held_joints
from .made_gait import RATE_FLAG, measured_gait, rate_words
from .motion import LEAST_PERIODS
from .result import FilmedRun, Remark
from .seeing.watch import Watched

LEAST_FRAMES = 10
SURELY = 4.0  # standard deviations
MOVED_WARN, MOVED_REFUSE = 0.015, 0.06  # of the floor's shift, in sides of a tag
SIDE_REFUSE = 0.08  # of a tag's side beside the links, relative
SMALL_TAG_PX = 20.0
BLUR_CELLS, BLUR_PX = 0.2, 1.0  # width of an edge, in cells of the tag, and at least
# Films of 1/30 s of exposure, 25 ms of readout, 48 degrees aslant: errors over sigmas, rms.
BLURRED = 2.5
APART = 1.4  # from a tag to the next one, over the distance of nearest neighbours
CENTRE_RAD = math.radians(1.0)  # a centre further off is worth a trim
PHASE_RAD = math.radians(45.0)  # no servo lags behind the others by so much
NEVER = math.inf


@dataclass(frozen=True)
class Check:
    """One thing that can be wrong with a film, or with what was measured in it.

    measure: of what was seen or fitted, a number or True; above `warn` it is a remark with this
    name, above `refuse` the film is refused. words: of the same and the number: what happened, the
    limit, what to do.
    """

    name: str
    measure: Callable[[Any], float]
    words: Callable[[Any, float], str]
    refuse: float = NEVER
    warn: float = 0.0


def run_checks(table: Iterable[Check], subject: Any) -> list[Remark]:
    """Return what there is to remark; raise BadInput with the words of the first refusal."""
    remarks = []
    for check in table:
        value = float(check.measure(subject))
        if value > check.refuse:
            raise BadInput(check.words(subject, value))
        if value > check.warn:
            remarks.append(Remark(check.name, check.words(subject, value)))
    return remarks


def _numbers(tags: Iterable[int]) -> str:
    return ", ".join(str(k + 1) for k in tags)


# ---- what was seen


def _side_px(w: Watched) -> float:
    return float(np.nanmedian(w.sightings.side_px))


def _other_numbers(w: Watched) -> list[int]:
    """Return numbers of tags that are on no link of the robot, misreadings left out."""
    numbers: list[int] = []
    for number, times in sorted(w.strangers.items()):
        # The window follows the robot's own tags: of those beyond, the next one counts, if rare.
        if not w.rare(times) or number - 1 in numbers:
            numbers.append(number)
    return numbers


def _frames_with_two(w: Watched) -> int:
    return int((w.sightings.visible.sum(axis=1) > 1).sum())


def _camera_moved(w: Watched) -> float:
    """Return by how much the floor surely moved, in sides of a tag."""
    shifts = () if w.plain_floor else w.shifts
    distances_px = [math.hypot(x, y) - SURELY * sigma for _, x, y, sigma in shifts]
    return max([0.0, *distances_px]) / _side_px(w)


def _camera_words(w: Watched, _: float) -> str:
    times, x, y, _sigma = np.array(w.shifts).T
    distances_px = np.hypot(x, y)
    when = times[np.argmax(distances_px > 0.5 * distances_px.max())]
    return (
        f"the camera moved by {distances_px.max():.1f} px, from {when:.1f} s on; more than "
        f"{MOVED_REFUSE * _side_px(w):.1f} px are refused. Put the phone on a tripod, switch "
        "stabilisation off, touch nothing while it films"
    )


def _lost_words(w: Watched, lost_share: float) -> str:
    lost = 1 - w.sightings.visible.mean(axis=0)
    return (
        f"tag {lost.argmax() + 1} is missing in {100 * lost_share:.0f} % of the frames, all "
        f"tags in {100 * lost.mean():.0f} %: look for glare, shadow, dirt, a long exposure, or "
        "the picture's edge. σ of its joints are as much wider"
    )


def blur_factor(w: Watched) -> float:
    """Return by what factor blur widens the standard deviations of a film's numbers."""
    px = w.edge_px[np.isfinite(w.edge_px)]
    wide = len(px) > 0 and float(np.quantile(px, 0.9)) > BLUR_PX
    return BLURRED if wide and _edge_cells(w) > BLUR_CELLS else 1.0


def _edge_cells(w: Watched) -> float:
    """Return the widest edges, in cells of a tag: of one frame in ten."""
    cells = w.edge_px / (w.sightings.side_px / 6)
    return float(np.nan_to_num(np.nanquantile(cells, 0.9)))


def _slow_motion(w: Watched) -> bool:
    capture = w.film.capture
    return capture is not None and (capture.stated or capture.time_scale != 1.0)


WATCHED = (
    Check(
        "short", lambda w: LEAST_FRAMES - len(w.sightings.t_s),
        lambda w, _: f"has {len(w.sightings.t_s)} of {LEAST_FRAMES} frames; film the robot for two "
        "periods or more",
        refuse=0,
    ),
    Check(
        "strangers", lambda w: max([0, *map(w.strangers.get, _other_numbers(w))])
        / len(w.sightings.t_s),
        lambda w, _: f"shows tags {_numbers(_other_numbers(w))}, but the robot has "
        f"{w.sightings.links} links: another robot? If it is this one, give --set "
        f"links={max(_other_numbers(w)) + 1}",
        refuse=0.2,
    ),
    Check(
        "no tags", lambda w: w.only_strays,
        lambda w, _: f"no tag is seen in {len(w.sightings.t_s)} frames; print ours with `serpenoid "
        "video tags`, with their white rim, at least 25 px a side in the film. AprilTags, other "
        "ArUco tags, the mirrored pictures of selfie cameras, and numbers that are seen twice in a "
        "picture do not count",
        refuse=0,
    ),
    Check(
        "few frames", lambda w: LEAST_FRAMES - _frames_with_two(w),
        lambda w, _: f"only {_frames_with_two(w)} of {len(w.sightings.t_s)} frames show two tags "
        "or more; go nearer, add light, and keep the whole robot in the picture",
        refuse=0,
    ),
    Check("camera", _camera_moved, _camera_words, MOVED_REFUSE, MOVED_WARN),
    Check(
        "floor", lambda w: w.plain_floor,
        lambda w, _: "the floor shows too little to check the camera, whether it stood still; lay "
        "something printed beside the track, or add light",
    ),
    Check(
        "tags lost", lambda w: 1 - w.sightings.visible.mean(axis=0).min(), _lost_words, warn=0.02
    ),
    Check(
        "small", lambda w: SMALL_TAG_PX - _side_px(w),
        lambda w, _: f"the tags are {_side_px(w):.0f} px wide; 33 px or more give the figures that "
        "are promised: go nearer or print larger. σ of phases and rate are up to 1.7 times too "
        "narrow",
    ),
    Check(
        "blur", blur_factor,
        lambda w, factor: f"the tags' edges are {_edge_cells(w):.2f} cells wide where they move: "
        f"add light or shorten the exposure; all σ are taken {factor:g} times as wide",
        warn=1,
    ),
    Check("slow motion", _slow_motion, lambda w, _: w.film.capture.in_words()),
)  # fmt: skip


# ---- the order of the tags, by their places (frames, links, 2)


def _steps(centres: Array) -> Array:
    """Return the mean distance from each tag to the next one, over that of nearest neighbours."""
    distances = np.linalg.norm(centres[:, :, None] - centres[:, None], axis=-1)
    mean = np.ma.masked_invalid(distances).mean(axis=0).filled(np.inf)
    nearest = np.median((mean + np.diag(np.full(len(mean), np.inf))).min(axis=0))
    steps = np.diagonal(mean, offset=1) / nearest
    return np.where(np.isfinite(steps), steps, 0.0)


PLACED = (
    Check(
        "order", lambda centres: _steps(centres).max(),
        lambda centres, _: f"tag {_steps(centres).argmax() + 1} and the next one are no "
        "neighbours; number 1 belongs on the tail, then 2, 3, ...: put them on anew",
        refuse=APART,
        warn=APART,
    ),
)  # fmt: skip


# ---- the camera that was fitted


FITTED = (
    Check(
        "scale", lambda b: b.scale_off,
        lambda b, excess: f"beside links of {1e3 * b.camera.link_m:.1f} mm the tags are "
        f"{1e3 * b.camera.side_m:.1f} mm wide, not {1e3 * b.side_m:.1f} mm: either the links have "
        "another length or the print another scale; measure both, and give --set link_length_m=... "
        f"or --tag-mm. Until then σ of all lengths and speeds holds these {excess:.1%}; more than "
        f"{SIDE_REFUSE:.0%} is refused",
        refuse=SIDE_REFUSE,
    ),
    Check(
        "tags", lambda b: b.turns.any(),
        lambda b, _: f"the arrows of tags {_numbers(np.flatnonzero(b.turns))} do not point to the "
        "head: allowed for, if number 1 is on the tail",
    ),
)  # fmt: skip


# ---- the chain that was followed


FOLLOWED = (
    Check(
        "hidden joint", lambda track: HELD_SHARE - held_joints(track).mean(axis=0).min(),
        lambda track, _: f"joint {held_joints(track).mean(axis=0).argmin() + 1} can be measured in "
        f"{held_joints(track).mean(axis=0).min():.0%} of the frames: a tag beside it is hidden or "
        f"out of the picture. {HELD_SHARE:.0%} are needed; keep the whole robot in the picture",
        refuse=0,
    ),
)  # fmt: skip


# ---- the motion that was fitted


def _periods(m: Measured) -> float:
    return m.motion.omega_rad_s * float(np.ptp(m.track.t_s)) / math.tau


def _rest_shares(m: Measured) -> Array:
    """Return what each joint's sine leaves, rms over its amplitude."""
    residual = np.where(m.joint_mask, m.motion.joint_residual_rad, 0.0)
    rest_rad = np.sqrt((residual**2).sum(axis=0) / np.maximum(m.joint_mask.sum(axis=0), 1))
    return np.asarray(rest_rad / m.motion.amplitude_rad)


MOVED = (
    Check(
        "still", lambda m: math.radians(1) - m.motion.amplitude_rad.max(),
        lambda m, _: "no joint moves by more than 1°: the robot does not crawl, or its servos have "
        "no power",
        refuse=0,
    ),
    Check(
        "periods", lambda m: LEAST_PERIODS - _periods(m),
        lambda m, _: f"shows {_periods(m):.2f} periods of "
        f"{math.tau / m.motion.omega_rad_s:.2g} s; at least {LEAST_PERIODS:g} are needed, "
        "two or more are better: film longer",
        refuse=0,
    ),
    Check(
        "no sine", lambda m: _rest_shares(m).max(),
        lambda m, share: f"joint {_rest_shares(m).argmax() + 1} leaves its sine by {share:.0%} of "
        "its amplitude: did the robot start, stop or change its gait in the film? Cut those parts "
        "off",
        warn=0.1,
    ),
)  # fmt: skip


def widened_sigmas(w: Watched, m: Measured) -> Array:
    """Return the standard deviations of a film's numbers with what checks found in them.

    They are wider for blur, for a camera that moved, and for links and tags that disagree. A floor
    that moves by s halfway through a film of length T changes a line's slope by 1.5 s / T.
    """
    camera, span_s = m.bundle.camera, float(np.ptp(m.track.t_s))
    drift_m_s = 1.5 * _camera_moved(w) * camera.side_m / span_s
    speed_m_s = max(m.motion.speed_m_s, 1e-9)
    sigmas = blur_factor(w) * m.sigmas
    drifts = drift_m_s / np.array([speed_m_s, 1.0, camera.links * camera.link_m])
    sigmas[-3:] = np.hypot(sigmas[-3:], drifts)  # direction, speed, turn
    sigmas[-2] = np.hypot(sigmas[-2], m.bundle.scale_off * speed_m_s)
    return sigmas


# ---- the servos, beside the commanded gait

Filmed = tuple[FilmedRun, Gait | None]  # what was measured, and the commanded gait


def _phases_off(filmed: Filmed) -> Array:
    """Return how far each joint is from its step in the gait, rad; 0 where a servo may lag so."""
    shift = np.array(measured_gait(*filmed).joint_shift_rad)
    return np.where(np.abs(shift) > PHASE_RAD, shift, 0.0)


def _phase_words(filmed: Filmed, _: float) -> str:
    off_deg = np.degrees(_phases_off(filmed))
    joints = [f"joint {k + 1} is {off_deg[k]:+.0f}°" for k in np.flatnonzero(off_deg)]
    return (
        f"{', '.join(joints)} out of step with the others: does the servo turn the wrong way (set "
        "its trim's sense to the other sign), or are two plugs swapped? Mend it, and film again"
    )


def _centres_off(filmed: Filmed) -> Array:
    """Return by how much each joint's centre is off, rad; 0 where a trim is not worth it."""
    run, gait = filmed
    commanded = gait.offset_rad if gait else 0.0
    excess = np.array([joint.offset_rad - commanded for joint in run.joints])
    sigma = np.array([joint.offset_sigma_rad for joint in run.joints])
    return np.where(np.abs(excess) > np.maximum(CENTRE_RAD, 2 * sigma), excess, 0.0)


def _centre_words(filmed: Filmed, _: float) -> str:
    run, off_deg = filmed[0], np.degrees(_centres_off(filmed))
    ends = run.joints[0], run.joints[-1]
    return "; ".join(
        f"joint {joint.joint} swings about {excess:+.1f}° ± "
        f"{math.degrees(joint.offset_sigma_rad):.1f}° off its centre: move its trim by "
        f"{-excess:+.1f}°"
        + (", unless the tag at that end is glued on askew" if joint in ends else "")
        for joint, excess in zip(run.joints, off_deg, strict=True)
        if excess
    )


def _rate_off(filmed: Filmed) -> float:
    """Return by how much the rate differs from the commanded one, relative; 0 within its sigma."""
    run, gait = filmed
    if gait is None:
        return 0.0
    excess = abs(run.omega_rad_s / gait.omega_rad_s - 1)
    return excess if excess > 4 * run.omega_sigma_rad_s / gait.omega_rad_s else 0.0


SERVOS = (
    Check("phase", lambda filmed: np.abs(_phases_off(filmed)).max(), _phase_words),
    Check("centre", lambda filmed: np.abs(_centres_off(filmed)).max(), _centre_words),
    Check("rate", _rate_off, lambda filmed, _: rate_words(*filmed), warn=RATE_FLAG),
)
