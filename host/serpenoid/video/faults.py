"""What can be wrong with a film: a row a fault, refused with the cure, or told beside numbers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ..model.errors import BadInput
from .fitting.camera import Camera
from .fitting.frames import Track
from .fitting.start import quarter_turns, tag_poses
from .instrument import Measured
from .motion import LEAST_PERIODS, path_basis
from .result import Remark
from .seeing.watch import Watched

Array = NDArray[np.float64]
T = TypeVar("T")
LEAST_FRAMES = 10
SURELY = 4.0  # standard deviations
MOVED_FLAG, MOVED_REFUSE = 0.015, 0.06  # of the floor's shift, in sides of a tag
SIDE_REFUSE = 0.08  # of a tag's side beside the links, relative
SMALL_TAG_PX = 20.0
STRANGER_SHARE = 0.2
BLUR_CELLS, BLUR_PX = 0.2, 1.0  # width of an edge, in cells of the tag, and at least
# Films of 1/30 s of exposure, 25 ms of readout, 48 degrees aslant: errors over sigmas, rms.
BLURRED = 2.5
# A line through four residuals on either side, up to the middle: what comes after less what was
# before. Noise of one frame counts 1.4 times, a smooth residual nearly nothing.
STEP = np.array([0.35, -0.05, -0.45, -0.85, 0.85, 0.45, -0.05, -0.35])
JOINTS_RAD, PATH_LINKS = math.radians(3.0), 0.05  # a step of 1
BESIDE_TYPICAL = 8.0  # times the median step of the film: a smaller one is none
BENT = 2.5  # times the typical residual of the other tags
MIXED = 1.1  # times the shortest way through all tags


@dataclass(frozen=True)
class Check(Generic[T]):
    """One fault, by what is known of a film.

    name: of its remark. measure: how bad it is. told, refused: beyond which it is told, and the
    film refused. words: or what gives them, by what is known and how bad it is.
    """

    name: str
    measure: Callable[[T], float]
    words: str | Callable[[T, float], str]
    told: float = math.inf
    refused: float = math.inf


def judged(checks: Iterable[Check[T]], known: T) -> list[Remark]:
    """Return what is to be told; raise BadInput for what is too bad."""
    remarks = []
    for check in checks:
        value = check.measure(known)
        if not value > min(check.told, check.refused):
            continue
        text = check.words if isinstance(check.words, str) else check.words(known, value)
        if value > check.refused:
            raise BadInput(text)
        remarks.append(Remark(check.name, text))
    return remarks


def _numbers(tags: Iterable[int]) -> str:
    return ", ".join(str(k + 1) for k in tags)


def _most(counts: dict[int, int], watched: Watched) -> float:
    return max(counts.values(), default=0) / len(watched.sightings.t_s)


def _strangers(w: Watched, _: float = 0.0) -> str:
    return (
        f"shows tags {_numbers(sorted(w.strangers))}, but the robot has {w.sightings.links} links: "
        f"another robot? If it is this one, give --links {max(w.strangers) + 1}"
    )


def _why_no_tag(watched: Watched, _: float) -> str:
    if watched.strangers:
        return _strangers(watched)
    if watched.mirrored:
        return (
            "the picture is mirrored, as selfie cameras do; use the camera at the back, or "
            "switch mirroring off"
        )
    return (
        f"no tag is seen in {len(watched.sightings.t_s)} frames; print them with `serpenoid "
        "video tags`, with their white rim, at least 25 px a side in the film"
    )


def _paired(watched: Watched) -> int:
    return int((watched.sightings.seen.sum(axis=1) >= 2).sum())


def _side_px(watched: Watched) -> float:
    return float(np.nanmedian(watched.sightings.side_px))


def widened(watched: Watched, measured: Measured) -> Array:
    """Return the standard deviations of a film's numbers, wider for blur and a camera that moved.

    A floor that moves by s halfway through a film of length T changes a line's slope by 1.5 s / T.
    """
    camera, span_s = measured.bundle.camera, float(np.ptp(measured.track.t_s))
    drift_m_s = 1.5 * _moved(watched) * camera.side_m / span_s
    speed_m_s = max(measured.fitted.motion.speed_m_s, 1e-9)
    sigmas = blurred(watched) * measured.sigmas
    drifts = drift_m_s / np.array([speed_m_s, 1.0, camera.links * camera.link_m])
    sigmas[-3:] = np.hypot(sigmas[-3:], drifts)  # direction, speed, turn
    return sigmas


def _moved(watched: Watched) -> float:
    """Return by how much the floor surely moved, in sides of a tag."""
    shifts = () if watched.plain_floor else watched.shifts
    far = [math.hypot(x, y) - SURELY * sigma for _, x, y, sigma in shifts]
    return max([0.0, *far]) / _side_px(watched)


def _how_it_moved(watched: Watched, value: float) -> str:
    side = _side_px(watched)
    times, x, y, _ = np.array(watched.shifts).T
    far = np.hypot(x, y) / side
    when = times[np.argmax(far > max(MOVED_FLAG, 0.5 * far.max()))]
    steps = np.hypot(np.diff(x, prepend=0.0), np.diff(y, prepend=0.0)) / side
    size = f"by {far.max() * side:.1f} px"
    how = f"moved {size} at {when:.1f} s"
    if np.mean(steps > 0.5 * MOVED_FLAG) > 0.4:
        how = f"moves all the time, {size}: held by hand, or stabilised"
    limit = f"; a floor that moves more than {MOVED_REFUSE * side:.1f} px is refused"
    return (
        f"the camera {how}. Put the phone on a tripod, switch stabilisation off, touch nothing "
        f"while it films{limit if value > MOVED_REFUSE else ''}"
    )


def _lost(watched: Watched) -> Array:
    return 1 - watched.sightings.seen.mean(axis=0)


def blurred(watched: Watched) -> float:
    """Return by what factor blur widens the standard deviations of a film's numbers."""
    px = watched.edge_px[np.isfinite(watched.edge_px)]
    wide = len(px) > 0 and float(np.quantile(px, 0.9)) > BLUR_PX
    return BLURRED if wide and _blur(watched) > BLUR_CELLS else 1.0


def _blur(watched: Watched) -> float:
    """Return the widest edges, in cells of a tag: of one frame in ten."""
    cells = watched.edge_px / (watched.sightings.side_px / 6)
    return float(np.nan_to_num(np.nanquantile(cells, 0.9)))


def _gaps(watched: Watched) -> tuple[Array, float]:
    gaps = np.diff(watched.sightings.t_s)
    return gaps, 1.6 * float(np.median(gaps))


def _frames_lost(watched: Watched) -> float:
    gaps, long = _gaps(watched)
    return float(np.round(gaps[gaps > long] * 1.6 / long - 1).sum())


def _ordinary(watched: Watched) -> Array:
    gaps, long = _gaps(watched)
    return gaps[gaps < long]


SEEN: tuple[Check[Watched], ...] = (
    Check(
        "picture",
        lambda w: 1 / len(w.sightings.t_s),
        "is a picture, not a film; film the robot for two periods or more",
        refused=0.9,
    ),
    Check(
        "doubles",
        lambda w: _most(w.doubles, w),
        lambda w, _: (
            f"two tags with the same number are in the picture (numbers "
            f"{_numbers(sorted(w.doubles))}): another robot, or tags that lie beside it? Take them "
            "away; where a number is seen twice, neither counts"
        ),
        0.0,
        STRANGER_SHARE,
    ),
    Check("no tag", lambda w: float(_lost(w).min()), _why_no_tag, refused=1 - 1e-9),
    Check("strangers", lambda w: _most(w.strangers, w), _strangers, 0.0, STRANGER_SHARE),
    Check(
        "few",
        lambda w: -_paired(w),
        lambda w, _: (
            f"only {_paired(w)} of {len(w.sightings.t_s) + w.damage.left_out} frames show two tags "
            "or more; go nearer, add light, and keep the whole robot in the picture"
        ),
        refused=0.5 - LEAST_FRAMES,
    ),
    Check("camera", _moved, _how_it_moved, MOVED_FLAG, MOVED_REFUSE),
    Check(
        "floor",
        lambda w: w.plain_floor,
        "the floor shows too little to check the camera, whether it stood still; lay something "
        "printed beside the track, or add light",
        0.5,
    ),
    Check(
        "rotated",
        lambda w: w.rotation_deg,
        lambda w, deg: (
            f"players turn this film by {deg:g}° to the left: it is measured as it was taken, and "
            "nothing changes but the picture's axes"
        ),
        0.0,
    ),
    Check(
        "tags lost",
        lambda w: float(_lost(w).max()),
        lambda w, worst: (
            f"tag {_lost(w).argmax() + 1} is missing in {100 * worst:.0f} % of the frames, all "
            f"tags in {100 * _lost(w).mean():.0f} %: look for glare, shadow, dirt, a long "
            "exposure, or the picture's edge. σ of its joints are as much wider"
        ),
        0.02,
    ),
    Check(
        "small",
        lambda w: -_side_px(w),
        lambda w, _: (
            f"the tags are {_side_px(w):.0f} px wide; 33 px or more give the figures that are "
            "promised: go nearer or print larger. σ of phases and rate are up to 1.7 times too "
            "narrow"
        ),
        -SMALL_TAG_PX,
    ),
    Check(
        "blur",
        blurred,
        lambda w, factor: (
            f"the tags' edges are {_blur(w):.2f} cells wide where they move: add light or shorten "
            f"the exposure; all σ are taken {factor:g} times as wide"
        ),
        1.0,
    ),
    Check(
        "frames lost",
        _frames_lost,
        lambda w, lost: (
            f"{lost:.0f} frames are missing, the longest gap is {_gaps(w)[0].max():.2f} s: the "
            "file's times are used"
        ),
        0.0,
    ),
    Check(
        "frame rate",
        lambda w: float(_ordinary(w).std() / np.median(_ordinary(w))),
        lambda w, _: (
            f"it varies between {1 / _ordinary(w).max():.1f} and {1 / _ordinary(w).min():.1f} "
            "frames/s: the file's times are used"
        ),
        0.02,
    ),
    Check(
        "damaged",
        lambda w: bool(w.damage),
        lambda w, _: f"{w.damage}: measured from what is left",
        0.5,
    ),
)


@dataclass(frozen=True)
class View:
    """A camera that was fitted to a film, and the side of the tags as printed, m."""

    watched: Watched
    camera: Camera
    side_m: float

    @property
    def quarters(self) -> NDArray[np.int64]:
        """Return by how many quarter turns each tag stands off the way to the head, 0 to 3."""
        turns = quarter_turns(*tag_poses(self.camera, self.watched.sightings))
        return np.round(turns / (np.pi / 2)).astype(int) % 4


VIEW: tuple[Check[View], ...] = (
    Check(
        "scale",
        lambda v: abs(v.camera.side_m / v.side_m - 1) if v.camera.links > 2 else 0.0,
        lambda v, off: (
            f"beside links of {1e3 * v.camera.link_m:.1f} mm the tags are "
            f"{1e3 * v.camera.side_m:.1f} mm wide, not {1e3 * v.side_m:.1f} mm: either the links "
            "have another length or the print another scale; measure both, and give --length-m or "
            "--tag-mm. Speeds go with the link length"
            + (f"; more than {SIDE_REFUSE:.0%} is refused" if off > SIDE_REFUSE else "")
        ),
        0.025,
        SIDE_REFUSE,
    ),
    Check(
        "tags",
        lambda v: float((v.quarters == 2).all()),
        "all arrows point to the tail. The tag with number 1 is taken for the tail's; if it is "
        "on the head, put the tags on anew",
        0.5,
    ),
    Check(
        "tags",
        lambda v: float(v.quarters.any() and (v.quarters != 2).any()),
        lambda v, _: (
            f"tags {_numbers(np.flatnonzero(v.quarters))} are upside down or a quarter turn round: "
            "allowed for"
        ),
        0.5,
    ),
)


def view_remarks(watched: Watched, camera: Camera, side_m: float) -> list[Remark]:
    """Return what is to be told of camera, tags and file, whatever the robot does."""
    return judged(VIEW, View(watched, camera, side_m)) + judged(SEEN, watched)


def _tag_order(centres: Array) -> tuple[list[int], float]:
    """Return the shortest way through all tags, and how much longer that by their numbers is.

    centres: the tags' places (frames, links, 2). [], 0 where there is no such way.
    """
    from scipy.sparse.csgraph import depth_first_order, minimum_spanning_tree

    gaps = np.linalg.norm(centres[:, :, None] - centres[:, None], axis=-1)
    there = np.isfinite(gaps)
    apart = np.where(there, gaps, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    tree = minimum_spanning_tree(apart).toarray()
    near = (tree + tree.T > 0).sum(axis=0)
    if (near > 2).any() or not near.all():
        return [], 0.0
    order = depth_first_order(tree, int(near.argmin()), directed=False)[0].tolist()
    far, least = (
        sum(apart[a, b] for a, b in itertools.pairwise(way)) for way in (range(len(apart)), order)
    )
    return order if order[0] < order[-1] else order[::-1], far / least


ORDER: tuple[Check[Array], ...] = (
    Check(
        "order",
        lambda centres: _tag_order(centres)[1],
        lambda centres, _: (
            f"the tags stand in the order {_numbers(_tag_order(centres)[0])} along the "
            "robot; number 1 belongs on the tail, then 2, 3, ...: put them on anew"
        ),
        refused=MIXED,
    ),
)


def _periods(m: Measured) -> float:
    return m.fitted.motion.omega_rad_s * float(np.ptp(m.track.t_s)) / math.tau


def _rest_rad(m: Measured) -> Array:
    """Return by how much each joint leaves its sine, rms."""
    rest = np.where(m.held, m.fitted.joints_rest_rad, 0.0)
    return np.sqrt((rest**2).sum(axis=0) / np.maximum(m.held.sum(axis=0), 1))


def _off_sine(m: Measured) -> Array:
    return _rest_rad(m) / m.fitted.motion.amplitude_rad


def _change(m: Measured) -> float:
    """Return by what share the speed changes over the film; 0 where it is short."""
    t = m.track.t_s - m.track.t_s.mean()
    motion = m.fitted.motion
    if motion.omega_rad_s * np.ptp(t) < 2 * np.pi * 2.9:
        return 0.0
    a = path_basis(t, motion.omega_rad_s, motion.turn_rad_s)
    faster = (t**2 - np.mean(t**2)) * np.exp(1j * np.arctan2(*motion.velocity_m_s[::-1]))
    z = m.track.states[:, 0] + 1j * m.track.states[:, 1]
    coefficients = np.linalg.lstsq(np.column_stack([a, faster]), z, rcond=None)[0]
    return abs(coefficients[-1].real) * 2 * float(np.ptp(t)) / motion.speed_m_s


def _jumps(m: Measured) -> tuple[Array, Array]:
    """Return by how much the joints, rad, and the robot, in links, step at each frame but few."""
    if len(m.track.t_s) <= len(STEP):
        return np.zeros(1), np.zeros(1)
    steps = np.abs(_steps(np.where(m.held, m.fitted.joints_rest_rad, np.nan)))
    few = np.isnan(steps).sum(axis=1) > steps.shape[1] // 2
    joints = np.where(few, np.nan, np.nanmedian(np.where(few[:, None], 0.0, steps), axis=1))
    known = m.fitted.path_weight > 0.3
    path = np.where(known, m.fitted.path_rest_m / m.bundle.camera.link_m, np.nan)
    return _unlike_others(joints), _unlike_others(np.abs(_steps(path)))


def _steps(rest: NDArray[Any]) -> NDArray[Any]:
    """Return by how much residuals (frames, ...) step between the frames 3 and 4 of each eight."""
    return np.asarray(sliding_window_view(rest, len(STEP), axis=0) @ STEP)


def _unlike_others(steps: Array) -> Array:
    """Return steps, 0 where they are like most of the film's."""
    known = np.nan_to_num(steps)
    usual = np.median(known[np.isfinite(steps)]) if np.isfinite(steps).any() else 0.0
    return np.where(known > BESIDE_TYPICAL * usual, known, 0.0)


def _jump(m: Measured) -> Array:
    joints, path = _jumps(m)
    return np.fmax(joints / JOINTS_RAD, path / PATH_LINKS)


def _where_it_jumps(m: Measured, value: float) -> str:
    worst = int(_jump(m).argmax())
    bend, way = (float(steps[worst]) for steps in _jumps(m))
    why = (
        "the film is cut there, or pictures are missing that its times do not tell. Give a part "
        "without cuts, as the phone wrote it"
        if value > 1
        else "was the camera, or the robot, nudged? Its speed is as far off. Film again"
    )
    return (
        f"the robot jumps at {m.track.t_s[worst + len(STEP) // 2]:.2f} s: joints by "
        f"{math.degrees(bend):.0f}°, its middle by {1e3 * way * m.bundle.camera.link_m:.0f} mm "
        f"beside its steady motion: {why}"
    )


MOTION: tuple[Check[Measured], ...] = (
    Check(
        "still",
        lambda m: -float(m.fitted.motion.amplitude_rad.max()),
        "no joint moves by more than 1°: the robot does not crawl, or its servos have no power",
        refused=-math.radians(1.0),
    ),
    Check(
        "short",
        lambda m: -_periods(m),
        lambda m, _: (
            f"shows {_periods(m):.2f} periods of {math.tau / m.fitted.motion.omega_rad_s:.2g} s; "
            f"at least {LEAST_PERIODS:g} are needed, two or more are better: film longer"
        ),
        refused=-LEAST_PERIODS,
    ),
    Check(
        "tags never seen",
        lambda m: m.assumed,
        "tags that are never seen leave their joints unmeasured; speed and turn are those of "
        "the tags that are there, and their size is the scale: print it exactly",
        0.5,
    ),
    Check(
        "no sine",
        lambda m: float(_off_sine(m).max()),
        lambda m, share: (
            f"joint {(worst := int(_off_sine(m).argmax())) + 1} leaves its sine by "
            f"{math.degrees(_rest_rad(m)[worst]):.1f}° ({100 * share:.0f} % of its amplitude): did "
            "the robot start, stop or change its gait in the film? Cut those parts off"
        ),
        0.1,
    ),
    Check(
        "unsteady",
        _change,
        lambda m, change: (
            f"the speed changes by {100 * change:.0f} % over the film: let the robot settle before "
            "you film, or film longer"
        ),
        0.05,
    ),
    Check("jump", lambda m: float(_jump(m).max()), _where_it_jumps, 0.4, 1.0),
)


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
