"""What can be wrong with a film: told beside its numbers, or the film is refused with the cure."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ..base.errors import BadInput
from .arrays import Array, Mask
from .fitting.camera import Camera
from .fitting.frames import Track
from .fitting.start import quarter_turns, tag_poses
from .instrument import Measured
from .motion import LEAST_PERIODS, path_basis
from .result import Remark
from .seeing.watch import Watched

LEAST_FRAMES = 10
SURELY = 4.0  # standard deviations
MOVED_FLAG, MOVED_REFUSE = 0.015, 0.06  # of the floor's shift, in sides of a tag
SIDE_FLAG, SIDE_REFUSE = 0.025, 0.08  # of a tag's side beside the links, relative
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


def remark(name: str, text: str, refused: bool = False) -> Remark:
    """Return a remark; raise BadInput with its text where the film is refused."""
    if refused:
        raise BadInput(text)
    return Remark(name, text)


def _numbers(tags: Iterable[int]) -> str:
    return ", ".join(str(k + 1) for k in tags)


def _side_px(watched: Watched) -> float:
    return float(np.nanmedian(watched.sightings.side_px))


def tag_faults(w: Watched) -> Iterator[Remark]:
    """Yield what is to be told of the tags in a film; raise BadInput if they are not enough."""
    frames, most = len(w.sightings.t_s), STRANGER_SHARE * len(w.sightings.t_s)
    if frames < 2:
        raise BadInput("is a picture, not a film; film the robot for two periods or more")
    if w.doubles:
        yield remark(
            "doubles",
            f"two tags with the same number are in the picture (numbers "
            f"{_numbers(sorted(w.doubles))}): another robot, or tags that lie beside it? Take them "
            "away; where a number is seen twice, neither counts",
            max(w.doubles.values()) > most,
        )
    strangers: list[int] = []
    for number, times in sorted(w.strangers.items()):
        # The window follows the robot's own tags: of those beyond, the next one counts, if rare.
        if not w.rare(times) or number - 1 in strangers:
            strangers.append(number)
    if w.only_strays:
        raise BadInput(_why_no_tag(w, strangers))
    if strangers:
        often = max(w.strangers.values()) > most
        yield remark("strangers", _strangers(w, strangers), often)
    paired = int((w.sightings.seen.sum(axis=1) >= 2).sum())
    if paired < LEAST_FRAMES:
        raise BadInput(
            f"only {paired} of {frames + w.damage.left_out} frames show two tags or more; go "
            "nearer, add light, and keep the whole robot in the picture"
        )


def _why_no_tag(watched: Watched, strangers: list[int]) -> str:
    if watched.family and not watched.mirrored:
        return (
            f"these are {watched.family}; print ours with `serpenoid video tags`, and glue them on "
            "instead"
        )
    if strangers:
        return _strangers(watched, strangers)
    if watched.mirrored:
        return (
            "the picture is mirrored, as selfie cameras do; use the camera at the back, or "
            "switch mirroring off"
        )
    return (
        f"no tag is seen in {len(watched.sightings.t_s)} frames; print them with `serpenoid "
        "video tags`, with their white rim, at least 25 px a side in the film"
    )


def _strangers(w: Watched, strangers: list[int]) -> str:
    return (
        f"shows tags {_numbers(strangers)}, but the robot has {w.sightings.links} links: "
        f"another robot? If it is this one, give --links {max(strangers) + 1}"
    )


def camera_faults(w: Watched) -> Iterator[Remark]:
    """Yield what is to be told of the camera's stand and turn; raise BadInput if it moved far."""
    moved = _moved(w)
    if moved > MOVED_FLAG:
        yield remark("camera", _how_it_moved(w, moved), moved > MOVED_REFUSE)
    if w.plain_floor:
        yield Remark(
            "floor",
            "the floor shows too little to check the camera, whether it stood still; lay something "
            "printed beside the track, or add light",
        )
    if w.rotation_deg:
        yield Remark(
            "rotated",
            f"players turn this film by {w.rotation_deg:g}° to the left: it is measured as it was "
            "taken, and nothing changes but the picture's axes",
        )


def _moved(watched: Watched) -> float:
    """Return by how much the floor surely moved, in sides of a tag."""
    shifts = () if watched.plain_floor else watched.shifts
    far = [math.hypot(x, y) - SURELY * sigma for _, x, y, sigma in shifts]
    return max([0.0, *far]) / _side_px(watched)


def _how_it_moved(watched: Watched, moved: float) -> str:
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
        f"while it films{limit if moved > MOVED_REFUSE else ''}"
    )


def picture_faults(w: Watched) -> Iterator[Remark]:
    """Yield what is to be told of the pictures: tags lost, small or blurred, frames, damage."""
    lost, side_px = 1 - w.sightings.seen.mean(axis=0), _side_px(w)
    if lost.max() > 0.02:
        yield Remark(
            "tags lost",
            f"tag {lost.argmax() + 1} is missing in {100 * lost.max():.0f} % of the frames, all "
            f"tags in {100 * lost.mean():.0f} %: look for glare, shadow, dirt, a long exposure, or "
            "the picture's edge. σ of its joints are as much wider",
        )
    if side_px < SMALL_TAG_PX:
        yield Remark(
            "small",
            f"the tags are {side_px:.0f} px wide; 33 px or more give the figures that are "
            "promised: go nearer or print larger. σ of phases and rate are up to 1.7 times too "
            "narrow",
        )
    if (factor := blurred(w)) > 1:
        yield Remark(
            "blur",
            f"the tags' edges are {_blur(w):.2f} cells wide where they move: add light or shorten "
            f"the exposure; all σ are taken {factor:g} times as wide",
        )
    capture = w.film.capture
    if capture is not None and (capture.stated or capture.time_scale != 1.0):
        yield Remark("slow motion", capture.in_words())
    gaps = np.diff(w.sightings.t_s)
    long = 1.6 * float(np.median(gaps))
    if missing := float(np.round(gaps[gaps > long] * 1.6 / long - 1).sum()):
        yield Remark(
            "frames lost",
            f"{missing:.0f} frames are missing, the longest gap is {gaps.max():.2f} s: the "
            "file's times are used",
        )
    usual = gaps[gaps < long]
    if usual.std() / np.median(usual) > 0.02:
        yield Remark(
            "frame rate",
            f"it varies between {1 / usual.max():.1f} and {1 / usual.min():.1f} "
            "frames/s: the file's times are used",
        )
    if w.damage:
        yield Remark("damaged", f"{w.damage}: measured from what is left")


def watched_faults(watched: Watched) -> list[Remark]:
    """Return what is to be told of a film that was watched; raise BadInput if it is of no use."""
    return [*tag_faults(watched), *camera_faults(watched), *picture_faults(watched)]


def blurred(watched: Watched) -> float:
    """Return by what factor blur widens the standard deviations of a film's numbers."""
    px = watched.edge_px[np.isfinite(watched.edge_px)]
    wide = len(px) > 0 and float(np.quantile(px, 0.9)) > BLUR_PX
    return BLURRED if wide and _blur(watched) > BLUR_CELLS else 1.0


def _blur(watched: Watched) -> float:
    """Return the widest edges, in cells of a tag: of one frame in ten."""
    cells = watched.edge_px / (watched.sightings.side_px / 6)
    return float(np.nan_to_num(np.nanquantile(cells, 0.9)))


def scale_off(camera: Camera, side_m: float) -> float:
    """Return how far links and tags disagree, relative: then all lengths may be as far off.

    0 up to SIDE_FLAG, which prints and tags askew explain. camera: fitted to the film. side_m: of a
    printed tag.
    """
    off = abs(camera.side_m / side_m - 1.0) if camera.links > 2 else 0.0
    return off if off > SIDE_FLAG else 0.0


def widened(watched: Watched, measured: Measured, side_m: float) -> Array:
    """Return the standard deviations of a film's numbers.

    They are wider for blur, for a camera that moved, and for links and tags that disagree; side_m:
    of a printed tag. A floor that moves by s halfway through a film of length T changes a line's
    slope by 1.5 s / T.
    """
    camera, span_s = measured.bundle.camera, float(np.ptp(measured.track.t_s))
    drift_m_s = 1.5 * _moved(watched) * camera.side_m / span_s
    speed_m_s = max(measured.fitted.motion.speed_m_s, 1e-9)
    sigmas = blurred(watched) * measured.sigmas
    drifts = drift_m_s / np.array([speed_m_s, 1.0, camera.links * camera.link_m])
    sigmas[-3:] = np.hypot(sigmas[-3:], drifts)  # direction, speed, turn
    sigmas[-2] = np.hypot(sigmas[-2], scale_off(camera, side_m) * speed_m_s)
    return sigmas


def view_faults(w: Watched, camera: Camera, side_m: float) -> list[Remark]:
    """Return what is to be told of camera, tags and file, whatever the robot does.

    camera: fitted to the film. side_m: of a printed tag. Raises BadInput.
    """
    remarks, off = list[Remark](), scale_off(camera, side_m)
    if off:
        text = (
            f"beside links of {1e3 * camera.link_m:.1f} mm the tags are "
            f"{1e3 * camera.side_m:.1f} mm wide, not {1e3 * side_m:.1f} mm: either the links "
            "have another length or the print another scale; measure both, and give --length-m or "
            f"--tag-mm. Until then σ of all lengths and speeds holds these {off:.1%}"
        )
        refused = off > SIDE_REFUSE
        limit = f"; more than {SIDE_REFUSE:.0%} is refused" if refused else ""
        remarks.append(remark("scale", text + limit, refused))
    turns = quarter_turns(*tag_poses(camera, w.sightings))
    quarters = np.round(turns / (np.pi / 2)).astype(int) % 4
    if (quarters == 2).all():
        text = (
            "all arrows point to the tail. The tag with number 1 is taken for the tail's; if it is "
            "on the head, put the tags on anew"
        )
        remarks.append(Remark("tags", text))
    elif quarters.any():
        turned = _numbers(np.flatnonzero(quarters))
        text = f"tags {turned} are upside down or a quarter turn round: allowed for"
        remarks.append(Remark("tags", text))
    return remarks + watched_faults(w)


def check_order(centres: Array) -> None:
    """Raise BadInput where the shortest way through all tags is not that by their numbers.

    centres: the tags' places (frames, links, 2). Nothing is told where that way has branches.
    """
    from scipy.sparse.csgraph import depth_first_order, minimum_spanning_tree

    gaps = np.linalg.norm(centres[:, :, None] - centres[:, None], axis=-1)
    there = np.isfinite(gaps)
    apart = np.where(there, gaps, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    tree = minimum_spanning_tree(apart).toarray()
    near = (tree + tree.T > 0).sum(axis=0)
    if (near > 2).any() or not near.all():
        return
    order = depth_first_order(tree, int(near.argmin()), directed=False)[0].tolist()
    far, least = (
        sum(apart[a, b] for a, b in itertools.pairwise(way)) for way in (range(len(apart)), order)
    )
    if far > MIXED * least:
        raise BadInput(
            f"the tags stand in the order {_numbers(min(order, order[::-1]))} along the robot; "
            "number 1 belongs on the tail, then 2, 3, ...: put them on anew"
        )


def motion_faults(m: Measured) -> Iterator[Remark]:
    """Yield what is to be told of the robot's motion; raise BadInput if it cannot be measured."""
    motion = m.fitted.motion
    if motion.amplitude_rad.max() < math.radians(1.0):
        raise BadInput(
            "no joint moves by more than 1°: the robot does not crawl, or its servos have no power"
        )
    periods = motion.omega_rad_s * float(np.ptp(m.track.t_s)) / math.tau
    if periods < LEAST_PERIODS:
        raise BadInput(
            f"shows {periods:.2f} periods of {math.tau / motion.omega_rad_s:.2g} s; "
            f"at least {LEAST_PERIODS:g} are needed, two or more are better: film longer"
        )
    if m.assumed:
        yield Remark(
            "tags never seen",
            "tags that are never seen leave their joints unmeasured; speed and turn are those of "
            "the tags that are there, and their size is the scale: print it exactly",
        )
    rest = np.where(m.held, m.fitted.joints_rest_rad, 0.0)
    rest_rad = np.sqrt((rest**2).sum(axis=0) / np.maximum(m.held.sum(axis=0), 1))
    worst = int((rest_rad / motion.amplitude_rad).argmax())
    share = rest_rad[worst] / motion.amplitude_rad[worst]
    if share > 0.1:
        yield Remark(
            "no sine",
            f"joint {worst + 1} leaves its sine by {math.degrees(rest_rad[worst]):.1f}° "
            f"({100 * share:.0f} % of its amplitude): did the robot start, stop or change its gait "
            "in the film? Cut those parts off",
        )
    if (change := _change(m)) > 0.05:
        yield Remark(
            "unsteady",
            f"the speed changes by {100 * change:.0f} % over the film: let the robot settle before "
            "you film, or film longer",
        )
    yield from jump_faults(m)


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


def jump_faults(m: Measured) -> Iterator[Remark]:
    """Yield where the robot steps out of its steady motion; raise BadInput for a cut film."""
    if len(m.track.t_s) <= len(STEP):
        return
    steps = np.abs(_steps(np.where(m.held, m.fitted.joints_rest_rad, np.nan)))
    few = np.isnan(steps).sum(axis=1) > steps.shape[1] // 2
    joints = np.where(few, np.nan, np.nanmedian(np.where(few[:, None], 0.0, steps), axis=1))
    path = np.where(m.fitted.path_weight > 0.3, m.fitted.path_rest_m, np.nan)
    bend, way_m = _unlike_others(joints), _unlike_others(np.abs(_steps(path)))
    jump = np.fmax(bend / JOINTS_RAD, way_m / (PATH_LINKS * m.bundle.camera.link_m))
    worst = int(jump.argmax())
    cut = bool(jump[worst] > 1.0)
    why = (
        "the film is cut there, or pictures are missing that its times do not tell. Give a part "
        "without cuts, as the phone wrote it"
        if cut
        else "was the camera, or the robot, nudged? Its speed is as far off. Film again"
    )
    if jump[worst] > 0.4:
        yield remark(
            "jump",
            f"the robot jumps at {m.track.t_s[worst + len(STEP) // 2]:.2f} s: joints by "
            f"{math.degrees(bend[worst]):.0f}°, its middle by {1e3 * way_m[worst]:.0f} mm beside "
            f"its steady motion: {why}",
            cut,
        )


def _steps(rest: NDArray[Any]) -> NDArray[Any]:
    """Return by how much residuals (frames, ...) step between the frames 3 and 4 of each eight."""
    return np.asarray(sliding_window_view(rest, len(STEP), axis=0) @ STEP)


def _unlike_others(steps: Array) -> Array:
    """Return steps, 0 where they are like most of the film's."""
    known = np.nan_to_num(steps)
    usual = np.median(known[np.isfinite(steps)]) if np.isfinite(steps).any() else 0.0
    return np.where(known > BESIDE_TYPICAL * usual, known, 0.0)


def bent_tags(track: Track) -> Mask:
    """Return which tags, (links,), are no flat squares: their corners fit far worse than others'.

    With fewer than four tags it is not clear which one is bent: none is named.
    """
    held = np.asarray(np.isfinite(track.rest_px).any(axis=0))
    typical = np.full(len(held), np.nan)
    typical[held] = np.nanmedian(track.rest_px[:, held], axis=0)
    bent = typical > BENT * np.nanmedian(typical)
    return bent if held.sum() >= 4 and bent.sum() <= held.sum() - 3 else np.zeros_like(bent)


def bent_faults(bent: Mask) -> list[Remark]:
    """Return what to tell of tags that were left out."""
    return [
        Remark(
            "bent tag",
            f"tag {link + 1} is no flat square: half peeled off, wet or bent? It is left out; "
            "stick it flat and film again",
        )
        for link in np.flatnonzero(bent)
    ]
