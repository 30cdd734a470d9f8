"""What can be wrong with a film: refused with the cure, or told beside the numbers."""

from __future__ import annotations

import math

import numpy as np

from ..model.errors import BadInput
from .fitting.bundle import Bundle
from .fitting.camera import Camera
from .fitting.start import quarter_turns, tag_poses
from .instrument import Measured
from .motion import LEAST_PERIODS
from .result import Remark
from .seeing.sightings import Sightings
from .seeing.watch import Watched

LEAST_FRAMES = 10
MOVED_FLAG, MOVED_REFUSE = 0.015, 0.06  # of the floor's shift, in sides of a tag
SIDE_FLAG, SIDE_REFUSE = 0.03, 0.08  # of a tag's side beside the links, relative
SMALL_TAG_PX = 20.0
STRANGER_SHARE = 0.2
LOST_SHARE = 0.02
BLUR_CELLS, BLUR_PX = 0.2, 1.0  # width of an edge, in cells of the tag, and at least
# Films of 1/30 s of exposure, 25 ms of readout, 48 degrees aslant: errors over sigmas, rms.
BLURRED = 2.5
STEADY_SHARE = 0.05  # of the speed: both halves beside each other
NOT_A_SINE = 0.1  # residual beside the amplitude


def refuse_unseen(watched: Watched, name: str) -> None:
    """Raise BadInput where a film cannot be measured at all, before anything is fitted."""
    s = watched.sightings
    frames = len(s.t_s)
    if frames == 1:
        raise BadInput(f"{name}: is a picture, not a film; film the robot for two periods or more")
    _refuse_doubles(watched, name)
    if not s.seen.any():
        raise BadInput(f"{name}: {_why_no_tag(watched)}")
    _refuse_another_robot(watched, name)
    good = s.seen.sum(axis=1) >= 2
    if good.sum() < LEAST_FRAMES:
        raise BadInput(
            f"{name}: only {int(good.sum())} of {frames + watched.damage.left_out} frames show two "
            "tags or more; go nearer, "
            "add light, and keep the whole robot in the picture"
        )


def _why_no_tag(watched: Watched) -> str:
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


def _strangers(watched: Watched) -> str:
    others = sorted(watched.strangers)
    links = watched.sightings.links
    return (
        f"shows tags {', '.join(str(k + 1) for k in others)}, but the robot has {links} links: "
        f"another robot? If it is this one, give --links {max(others) + 1}"
    )


def _refuse_another_robot(watched: Watched, name: str) -> None:
    often = max(watched.strangers.values(), default=0)
    if often > STRANGER_SHARE * len(watched.sightings.t_s):
        raise BadInput(f"{name}: {_strangers(watched)}")


def _refuse_doubles(watched: Watched, name: str) -> None:
    often = max(watched.doubles.values(), default=0)
    if often > STRANGER_SHARE * len(watched.sightings.t_s):
        raise BadInput(f"{name}: {_doubles(watched)}")


def _doubles(watched: Watched) -> str:
    numbers = ", ".join(str(k + 1) for k in sorted(watched.doubles))
    return (
        f"two tags with the same number are in the picture (numbers {numbers}): another robot, or "
        "tags that lie beside it? Take them away; where a number is seen twice, neither counts"
    )


def camera_moved(watched: Watched) -> Remark | None:
    """Tell of a camera that moved; raise BadInput where it moved too much."""
    if not watched.shifts:
        return None
    side = float(np.nanmedian(watched.sightings.side_px))
    times, x, y = np.array(watched.shifts).T
    far = np.hypot(x, y) / side
    if far.max() < MOVED_FLAG:
        return None
    when = times[np.argmax(far > max(MOVED_FLAG, 0.5 * far.max()))]
    steps = np.hypot(np.diff(x, prepend=0.0), np.diff(y, prepend=0.0)) / side
    always = np.isfinite(far).all() and np.mean(steps > 0.5 * MOVED_FLAG) > 0.4
    size = "out of sight" if not np.isfinite(far.max()) else f"by {far.max() * side:.1f} px"
    how = (
        f"moves all the time, {size}: held by hand, or stabilised"
        if always
        else f"moved {size} at {when:.1f} s"
    )
    text = (
        f"the camera {how}. Put the phone on a tripod, switch stabilisation off, touch nothing "
        "while it films"
    )
    if far.max() > MOVED_REFUSE:
        raise BadInput(
            f"{watched.film.path}: {text}; a floor that moves more than "
            f"{MOVED_REFUSE * side:.1f} px is refused"
        )
    return Remark("camera", text)


def remarks_of(watched: Watched, measured: Measured, side_m: float, name: str) -> list[Remark]:
    """Return what is to be told of a film that was measured; raise BadInput for what is too bad."""
    _refuse_short(measured, name)
    told = [_assumed(measured), _not_a_sine(measured), _unsteady(measured)]
    view = remarks_of_view(watched, measured.bundle, side_m, name)
    return [remark for remark in told if remark is not None] + view


def remarks_of_view(watched: Watched, fit: Bundle, side_m: float, name: str) -> list[Remark]:
    """Return what is to be told of camera, tags and file, whatever the robot does."""
    told = [
        camera_moved(watched),
        _plain(watched),
        _rotated(watched),
        _side(fit.camera, side_m, name),
        *_turned(watched, fit.camera),
        *_seen(watched),
        *_times(watched),
        _strangers_told(watched),
        Remark("doubles", _doubles(watched)) if watched.doubles else None,
    ]
    if watched.damage:
        told.append(Remark("damaged", f"{watched.damage}: measured from what is left"))
    return [remark for remark in told if remark is not None]


def _assumed(measured: Measured) -> Remark | None:
    if not measured.assumed:
        return None
    return Remark(
        "tags never seen",
        "tags that are never seen leave their joints unmeasured; speed and turn are those of the "
        "tags that are there, and their size is the scale: print it exactly",
    )


def _refuse_short(measured: Measured, name: str) -> None:
    m = measured.fitted.motion
    span = float(np.ptp(measured.track.t_s))
    if m.amplitude_rad.max() < math.radians(1.0):
        raise BadInput(
            f"{name}: no joint moves by more than 1°: the robot does not crawl, or its "
            "servos have no power"
        )
    periods = m.omega_rad_s * span / (2 * np.pi)
    if periods < LEAST_PERIODS:
        raise BadInput(
            f"{name}: shows {periods:.2f} periods of {2 * np.pi / m.omega_rad_s:.2g} s; at least "
            f"{LEAST_PERIODS:g} are needed, two or more are better: film longer"
        )


def _plain(watched: Watched) -> Remark | None:
    if not watched.plain_floor:
        return None
    return Remark(
        "floor",
        "the floor is too plain to tell whether the camera stood still; lay "
        "something printed beside the track",
    )


def _rotated(watched: Watched) -> Remark | None:
    if not watched.rotation_deg:
        return None
    return Remark(
        "rotated",
        f"players turn this film by {watched.rotation_deg}° to the left: it is measured as it was "
        "taken, and nothing changes but the picture's axes",
    )


def _side(camera: Camera, side_m: float, name: str) -> Remark | None:
    found = camera.side_m
    off = found / side_m - 1
    if abs(off) < SIDE_FLAG or camera.links < 3:
        return None
    text = (
        f"beside links of {1e3 * camera.link_m:.1f} mm the tags are "
        f"{1e3 * found:.1f} mm wide, not {1e3 * side_m:.1f} mm: either the links have another "
        f"length or the print another scale; measure both, and give --length-m or --tag-mm. "
        f"Speeds go with the link length"
    )
    if abs(off) > SIDE_REFUSE:
        raise BadInput(f"{name}: {text}; more than {100 * SIDE_REFUSE:.0f} % is refused")
    return Remark("scale", text)


def _turned(watched: Watched, camera: Camera) -> list[Remark]:
    turns = quarter_turns(*tag_poses(camera, watched.sightings))
    quarters = np.round(turns / (np.pi / 2)).astype(int) % 4
    if (quarters == 2).all():
        return [
            Remark(
                "tags",
                "all arrows point to the tail. The tag with number 1 is taken for "
                "the tail's; if it is on the head, put the tags on anew",
            )
        ]
    return [
        Remark("tags", f"tag {i + 1} is {words}: allowed for")
        for i, q in enumerate(quarters)
        if (
            words := {1: "a quarter turn round", 2: "upside down", 3: "a quarter turn round"}.get(q)
        )
    ]


def _seen(watched: Watched) -> list[Remark]:
    s = watched.sightings
    told = []
    lost = 1 - s.seen.mean(axis=0)
    worst = int(lost.argmax())
    if lost[worst] > LOST_SHARE:
        told.append(
            Remark(
                "tags lost",
                f"tag {worst + 1} is missing in {100 * lost[worst]:.0f} % "
                f"of the frames, all tags in {100 * lost.mean():.0f} %: "
                f"{_why_lost(watched)}",
            )
        )
    side = float(np.nanmedian(s.side_px))
    if side < SMALL_TAG_PX:
        told.append(
            Remark(
                "small",
                f"the tags are {side:.0f} px wide; 33 px or more give the "
                "figures that are promised: go nearer or print larger. σ of phases and rate are "
                "up to 1.7 times too narrow",
            )
        )
    if blurred(watched) > 1.0:
        told.append(
            Remark(
                "blur",
                f"the tags' edges are {_blur(watched):.2f} cells wide where they move: add "
                f"light or shorten the exposure; all σ are taken {BLURRED:g} times as wide",
            )
        )
    return told


def blurred(watched: Watched) -> float:
    """Return by what factor blur widens the standard deviations of a film's numbers."""
    px = watched.edge_px[np.isfinite(watched.edge_px)]
    wide = len(px) > 0 and float(np.quantile(px, 0.9)) > BLUR_PX
    return BLURRED if wide and _blur(watched) > BLUR_CELLS else 1.0


def _blur(watched: Watched) -> float:
    """Return the widest edges, in cells of a tag: of one frame in ten."""
    cells = watched.edge_px / (watched.sightings.side_px / 6)
    cells = cells[np.isfinite(cells)]
    return float(np.quantile(cells, 0.9)) if len(cells) else 0.0


def _why_lost(watched: Watched) -> str:
    """Say why tags are lost: because they move fast, or because of where they are."""
    s = watched.sightings
    speed = _speeds(s)
    lost, kept = speed[~s.seen], speed[s.seen]
    lost, kept = lost[np.isfinite(lost)], kept[np.isfinite(kept)]
    if len(lost) > 3 and np.median(lost) > 1.3 * np.median(kept):
        return "those that move fast: the exposure is long; add light"
    return "look for glare, shadow, dirt, or the picture's edge"


def _speeds(s: Sightings) -> np.ndarray:
    """Return each tag's speed, px/s, also where it is lost: between the frames that have it."""
    middles = s.corners_px.mean(axis=2)
    out = np.full(s.seen.shape, np.nan)
    for i in range(s.links):
        there = np.flatnonzero(s.seen[:, i])
        if len(there) > 2:
            at = np.stack([np.interp(s.t_s, s.t_s[there], middles[there, i, k]) for k in (0, 1)])
            out[:, i] = np.hypot(*np.gradient(at, s.t_s, axis=1))
    return out


def _times(watched: Watched) -> list[Remark]:
    gaps = np.diff(watched.sightings.t_s)
    usual = float(np.median(gaps))
    lost = int(np.round(gaps[gaps > 1.6 * usual] / usual - 1).sum())
    told = []
    if lost:
        told.append(
            Remark(
                "frames lost",
                f"{lost} frames are missing, the longest gap is "
                f"{gaps.max():.2f} s: the file's times are used",
            )
        )
    ordinary = gaps[gaps < 1.6 * usual]
    if float(ordinary.std()) > 0.02 * usual:
        told.append(
            Remark(
                "frame rate",
                f"it varies between {1 / ordinary.max():.1f} and "
                f"{1 / ordinary.min():.1f} frames/s: the file's times are used",
            )
        )
    return told


def _not_a_sine(measured: Measured) -> Remark | None:
    rest = np.where(measured.held, measured.fitted.joints_rest_rad, 0.0)
    rms = np.sqrt((rest**2).sum(axis=0) / np.maximum(measured.held.sum(axis=0), 1))
    share = rms / measured.fitted.motion.amplitude_rad
    worst = int(share.argmax())
    if share[worst] < NOT_A_SINE:
        return None
    return Remark(
        "no sine",
        f"joint {worst + 1} leaves its sine by {math.degrees(rms[worst]):.1f}° "
        f"({100 * share[worst]:.0f} % of its amplitude): did the robot start, stop or "
        "change its gait in the film? Cut those parts off",
    )


def _unsteady(measured: Measured) -> Remark | None:
    """Tell where the speed changes over the film: by a fit of each half."""
    from .motion import path_basis

    t = measured.track.t_s - measured.track.t_s.mean()
    m = measured.fitted.motion
    if m.omega_rad_s * np.ptp(t) < 2 * np.pi * 2.9:
        return None
    a = path_basis(t, m.omega_rad_s, m.turn_rad_s)
    faster = (t**2 - np.mean(t**2)) * np.exp(1j * np.arctan2(*m.velocity_m_s[::-1]))
    z = measured.track.states[:, 0] + 1j * measured.track.states[:, 1]
    found = np.linalg.lstsq(np.column_stack([a, faster]), z, rcond=None)[0]
    change = abs(found[-1].real) * 2 * np.ptp(t) / m.speed_m_s
    if change < STEADY_SHARE:
        return None
    return Remark(
        "unsteady",
        f"the speed changes by {100 * change:.0f} % over the film: let the "
        "robot settle before you film, or film longer",
    )


def _strangers_told(watched: Watched) -> Remark | None:
    return Remark("strangers", _strangers(watched)) if watched.strangers else None
