"""What can be wrong with a film: one table of checks, each with its measure, limits and words.

A check warns, which is a remark beside the film's numbers, or refuses the film with the cure.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import BadInput
from .arrays import Array
from .fitting.camera import Camera
from .fitting.frames import Track
from .fitting.start import quarter_turns, tag_poses
from .instrument import HELD_SHARE, Measured, held_joints
from .motion import LEAST_PERIODS
from .result import Remark
from .seeing.watch import Watched

LEAST_FRAMES = 10
SURELY = 4.0  # standard deviations
MOVED_WARN, MOVED_REFUSE = 0.015, 0.06  # of the floor's shift, in sides of a tag
SIDE_WARN, SIDE_REFUSE = 0.025, 0.08  # of a tag's side beside the links, relative
SMALL_TAG_PX = 20.0
BLUR_CELLS, BLUR_PX = 0.2, 1.0  # width of an edge, in cells of the tag, and at least
# Films of 1/30 s of exposure, 25 ms of readout, 48 degrees aslant: errors over sigmas, rms.
BLURRED = 2.5
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
    warn: float
    refuse: float
    words: Callable[[Any, float], str]


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


def side_px(w: Watched) -> float:
    """Return the typical side of a tag, px."""
    return float(np.nanmedian(w.sightings.side_px))


def _share(w: Watched, counts: Iterable[int]) -> float:
    return max(counts, default=0) / len(w.sightings.t_s)


def _other_numbers(w: Watched) -> list[int]:
    """Return numbers of tags that are on no link of the robot, misreadings left out."""
    numbers: list[int] = []
    for number, times in sorted(w.strangers.items()):
        # The window follows the robot's own tags: of those beyond, the next one counts, if rare.
        if not w.rare(times) or number - 1 in numbers:
            numbers.append(number)
    return numbers


def _no_tags_words(w: Watched, _: float) -> str:
    if w.family and not w.mirrored:
        return (
            f"these are {w.family}; print ours with `serpenoid video tags`, and glue them on "
            "instead"
        )
    if _other_numbers(w):
        return _other_numbers_words(w)
    if w.mirrored:
        return (
            "the picture is mirrored, as selfie cameras do; use the camera at the back, or "
            "switch mirroring off"
        )
    return (
        f"no tag is seen in {len(w.sightings.t_s)} frames; print them with `serpenoid "
        "video tags`, with their white rim, at least 25 px a side in the film"
    )


def _other_numbers_words(w: Watched, _: float = 0.0) -> str:
    numbers = _other_numbers(w)
    return (
        f"shows tags {_numbers(numbers)}, but the robot has {w.sightings.links} links: "
        f"another robot? If it is this one, give --set links={max(numbers) + 1}"
    )


def _frames_with_two(w: Watched) -> int:
    return int((w.sightings.seen.sum(axis=1) >= 2).sum())


def camera_moved(w: Watched) -> float:
    """Return by how much the floor surely moved, in sides of a tag."""
    shifts = () if w.plain_floor else w.shifts
    far = [math.hypot(x, y) - SURELY * sigma for _, x, y, sigma in shifts]
    return max([0.0, *far]) / side_px(w)


def _camera_words(w: Watched, moved: float) -> str:
    side = side_px(w)
    times, x, y, _ = np.array(w.shifts).T
    far = np.hypot(x, y) / side
    when = times[np.argmax(far > max(MOVED_WARN, 0.5 * far.max()))]
    steps = np.hypot(np.diff(x, prepend=0.0), np.diff(y, prepend=0.0)) / side
    size = f"by {far.max() * side:.1f} px"
    how = f"moved {size} at {when:.1f} s"
    if np.mean(steps > 0.5 * MOVED_WARN) > 0.4:
        how = f"moves all the time, {size}: held by hand, or stabilised"
    limit = f"; a floor that moves more than {MOVED_REFUSE * side:.1f} px is refused"
    return (
        f"the camera {how}. Put the phone on a tripod, switch stabilisation off, touch nothing "
        f"while it films{limit if moved > MOVED_REFUSE else ''}"
    )


def _lost_words(w: Watched, most: float) -> str:
    lost = 1 - w.sightings.seen.mean(axis=0)
    return (
        f"tag {lost.argmax() + 1} is missing in {100 * most:.0f} % of the frames, all "
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


SEEN = (
    Check(
        "picture", lambda w: len(w.sightings.t_s) < 2, 0, 0,
        lambda w, _: "is a picture, not a film; film the robot for two periods or more",
    ),
    Check(
        "doubles", lambda w: _share(w, w.doubles.values()), 0, 0.2,
        lambda w, _: f"two tags with the same number are in the picture (numbers "
        f"{_numbers(sorted(w.doubles))}): another robot, or tags that lie beside it? Take them "
        "away; where a number is seen twice, neither counts",
    ),
    Check("no tags", lambda w: w.only_strays, 0, 0, _no_tags_words),
    Check(
        "strangers", lambda w: _share(w, w.strangers.values()) if _other_numbers(w) else 0,
        0, 0.2, _other_numbers_words,
    ),
    Check(
        "few frames", lambda w: LEAST_FRAMES - _frames_with_two(w), 0, 0,
        lambda w, _: f"only {_frames_with_two(w)} of {len(w.sightings.t_s)} frames show two tags "
        "or more; go nearer, add light, and keep the whole robot in the picture",
    ),
    Check("camera", camera_moved, MOVED_WARN, MOVED_REFUSE, _camera_words),
    Check(
        "floor", lambda w: w.plain_floor, 0, NEVER,
        lambda w, _: "the floor shows too little to check the camera, whether it stood still; lay "
        "something printed beside the track, or add light",
    ),
    Check("tags lost", lambda w: 1 - w.sightings.seen.mean(axis=0).min(), 0.02, NEVER, _lost_words),
    Check(
        "small", lambda w: SMALL_TAG_PX - side_px(w), 0, NEVER,
        lambda w, _: f"the tags are {side_px(w):.0f} px wide; 33 px or more give the figures that "
        "are promised: go nearer or print larger. σ of phases and rate are up to 1.7 times too "
        "narrow",
    ),
    Check(
        "blur", blur_factor, 1, NEVER,
        lambda w, factor: f"the tags' edges are {_edge_cells(w):.2f} cells wide where they move: "
        f"add light or shorten the exposure; all σ are taken {factor:g} times as wide",
    ),
    Check("slow motion", _slow_motion, 0, NEVER, lambda w, _: w.film.capture.in_words()),
    Check(
        "damaged", lambda w: bool(w.damage), 0, NEVER,
        lambda w, _: f"{w.damage}: measured from what comes before",
    ),
)  # fmt: skip


# ---- the order of the tags, by their places (frames, links, 2)


def _shortest_way(centres: Array) -> tuple[float, list[int]]:
    """Return how much longer the way by numbers is than the shortest way through all tags, and
    that way; 1 and none where it has branches."""
    from scipy.sparse.csgraph import depth_first_order, minimum_spanning_tree

    gaps = np.linalg.norm(centres[:, :, None] - centres[:, None], axis=-1)
    there = np.isfinite(gaps)
    apart = np.where(there, gaps, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    tree = minimum_spanning_tree(apart).toarray()
    near = (tree + tree.T > 0).sum(axis=0)
    if (near > 2).any() or not near.all():
        return 1.0, []
    order = depth_first_order(tree, int(near.argmin()), directed=False)[0].tolist()
    far, least = (
        sum(apart[a, b] for a, b in itertools.pairwise(way)) for way in (range(len(apart)), order)
    )
    return far / least, min(order, order[::-1])


PLACED = (
    Check(
        "order", lambda centres: _shortest_way(centres)[0], 1.1, 1.1,
        lambda centres, _: f"the tags stand in the order {_numbers(_shortest_way(centres)[1])} "
        "along the robot; number 1 belongs on the tail, then 2, 3, ...: put them on anew",
    ),
)  # fmt: skip


# ---- the camera that was fitted


@dataclass(frozen=True)
class View:
    """A film with its fitted camera and the printed side of a tag, m."""

    watched: Watched
    camera: Camera
    side_m: float

    @property
    def quarters(self) -> NDArray[Any]:
        """Return by how many quarter turns each tag is put on."""
        turns = quarter_turns(*tag_poses(self.camera, self.watched.sightings))
        return np.round(turns / (np.pi / 2)).astype(int) % 4

    @property
    def scale_off(self) -> float:
        """Return how far links and tags disagree, relative: then all lengths may be as far off.

        0 up to SIDE_WARN, which prints and tags askew explain.
        """
        off = abs(self.camera.side_m / self.side_m - 1.0) if self.camera.links > 2 else 0.0
        return off if off > SIDE_WARN else 0.0


def _scale_words(v: View, off: float) -> str:
    limit = f"; more than {SIDE_REFUSE:.0%} is refused" if off > SIDE_REFUSE else ""
    return (
        f"beside links of {1e3 * v.camera.link_m:.1f} mm the tags are "
        f"{1e3 * v.camera.side_m:.1f} mm wide, not {1e3 * v.side_m:.1f} mm: either the links "
        "have another length or the print another scale; measure both, and give --set "
        "link_length_m=... or --tag-mm. Until then σ of all lengths and speeds holds these "
        f"{off:.1%}{limit}"
    )


def _turned_words(v: View, _: float) -> str:
    if (v.quarters == 2).all():
        return (
            "all arrows point to the tail. The tag with number 1 is taken for the tail's; if it is "
            "on the head, put the tags on anew"
        )
    turned = _numbers(np.flatnonzero(v.quarters))
    return f"tags {turned} are upside down or a quarter turn round: allowed for"


FITTED = (
    Check("scale", lambda v: v.scale_off, 0, SIDE_REFUSE, _scale_words),
    Check("tags", lambda v: v.quarters.any(), 0, NEVER, _turned_words),
)


# ---- the chain that was followed


def _bent_tags(track: Track) -> Array:
    """Return for each tag its residual over that of the others; zeros where it is not clear."""
    held = np.asarray(np.isfinite(track.rest_px).any(axis=0))
    ratio = np.zeros(len(held))
    if held.sum() >= 4:
        ratio[held] = np.nanmedian(track.rest_px[:, held], axis=0)
        ratio /= np.median(ratio[held])
    return ratio


FOLLOWED = (
    Check(
        "hidden joint", lambda track: HELD_SHARE - held_joints(track).mean(axis=0).min(), 0, 0,
        lambda track, _: f"joint {held_joints(track).mean(axis=0).argmin() + 1} can be measured in "
        f"{held_joints(track).mean(axis=0).min():.0%} of the frames: a tag beside it is hidden or "
        f"out of the picture. {HELD_SHARE:.0%} are needed; keep the whole robot in the picture",
    ),
    Check(
        "bent tag", lambda track: _bent_tags(track).max(), 2.5, 2.5,
        lambda track, _: f"tag {_bent_tags(track).argmax() + 1} is no flat square: half peeled "
        "off, wet or bent? Stick it flat and film again",
    ),
)  # fmt: skip


# ---- the motion that was fitted


def _periods(m: Measured) -> float:
    return m.fitted.motion.omega_rad_s * float(np.ptp(m.track.t_s)) / math.tau


def _rest_shares(m: Measured) -> Array:
    """Return what each joint's sine leaves, rms over its amplitude."""
    rest = np.where(m.held, m.fitted.joints_rest_rad, 0.0)
    rest_rad = np.sqrt((rest**2).sum(axis=0) / np.maximum(m.held.sum(axis=0), 1))
    return np.asarray(rest_rad / m.fitted.motion.amplitude_rad)


def _no_sine_words(m: Measured, share: float) -> str:
    joint = int(_rest_shares(m).argmax())
    degrees = math.degrees(share * m.fitted.motion.amplitude_rad[joint])
    return (
        f"joint {joint + 1} leaves its sine by {degrees:.1f}° ({100 * share:.0f} % of its "
        "amplitude): did the robot start, stop or change its gait in the film? Cut those parts off"
    )


MOVED = (
    Check(
        "still", lambda m: math.radians(1) - m.fitted.motion.amplitude_rad.max(), 0, 0,
        lambda m, _: "no joint moves by more than 1°: the robot does not crawl, or its servos have "
        "no power",
    ),
    Check(
        "periods", lambda m: LEAST_PERIODS - _periods(m), 0, 0,
        lambda m, _: f"shows {_periods(m):.2f} periods of "
        f"{math.tau / m.fitted.motion.omega_rad_s:.2g} s; at least {LEAST_PERIODS:g} are needed, "
        "two or more are better: film longer",
    ),
    Check("no sine", lambda m: _rest_shares(m).max(), 0.1, NEVER, _no_sine_words),
)  # fmt: skip


def widened_sigmas(view: View, m: Measured) -> Array:
    """Return the standard deviations of a film's numbers with what checks found in them.

    They are wider for blur, for a camera that moved, and for links and tags that disagree. A floor
    that moves by s halfway through a film of length T changes a line's slope by 1.5 s / T.
    """
    camera, span_s = view.camera, float(np.ptp(m.track.t_s))
    drift_m_s = 1.5 * camera_moved(view.watched) * camera.side_m / span_s
    speed_m_s = max(m.fitted.motion.speed_m_s, 1e-9)
    sigmas = blur_factor(view.watched) * m.sigmas
    drifts = drift_m_s / np.array([speed_m_s, 1.0, camera.links * camera.link_m])
    sigmas[-3:] = np.hypot(sigmas[-3:], drifts)  # direction, speed, turn
    sigmas[-2] = np.hypot(sigmas[-2], view.scale_off * speed_m_s)
    return sigmas
