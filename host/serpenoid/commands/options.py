"""Options that several commands share, and functions that turn them into robot, gait and servo."""

from __future__ import annotations

import json
import math
import threading
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import click

import serpenoid as sn

from ..base.checks import CHOICES, NOT_NEGATIVE, POSITIVE, Limits
from ..base.errors import BadInput
from ..base.files import write_text
from ..model.capture_rate import OPTION
from ..show.screen import say, working
from .declare import (
    FOLDER,
    SETTINGS,
    OutFile,
    Setting,
    Values,
    flag,
    group_settings,
    number,
    option,
    parsed_number,
    refuse_unused,
    row,
)

T = TypeVar("T")
IDEAL = "ideal"


def _typed_gaits(_ctx: click.Context, _option: click.Parameter, gaits: Any) -> list[sn.Gait]:
    return [sn.Gait.degrees(alpha, beta, hertz=hertz) for alpha, beta, hertz in gaits]


row("as_json", flag("--json", "as_json", "Answer with JSON."))
row("verbose", flag("--verbose", "Print errors, margins and other powers too."))
row(
    "capture_fps",
    number(
        OPTION,
        "Frames a second that the camera recorded, for slow motion whose file does not state it.",
    ),
)
row("session", click.argument("session", type=FOLDER))
row("folder", click.argument("folder", type=FOLDER))
row(
    "robot",
    option(
        "--robot",
        "Robot and its friction: 2005 (the paper's real robot, the default), paper (the one of its "
        "theory), a session's folder, a fit.json, or a scene (.toml).",
        metavar="2005|paper|FILE|SESSION",
    ),
)
row(
    "typed_gait",
    number("--alpha-deg", "Amplitude of the joints, half of their swing, in degrees."),
    number("--beta-deg", "Phase lag from joint to joint, in degrees."),
    number("--frequency-hz", "Cycles of the gait a second."),
    number("--omega-rad-s", "Angular rate of the gait, in place of its frequency."),
)
row(
    "gaits",
    number(
        "--gait",
        "gaits",
        "A gait to predict, beside the session's.",
        nargs=3,
        multiple=True,
        metavar="ALPHA_DEG BETA_DEG HZ",
        callback=_typed_gaits,
    ),
)
row(
    "servo",
    option(
        "--servo",
        "Servos of the joints: hobby (any), SG90, MG996R, ..., a TOML file, or ideal.",
        metavar="NAME|FILE|ideal",
    ),
)
row(
    "formulation",
    option(
        "--formulation",
        "The exact model (explicit, the default), or the paper's with springs in the joints.",
        choice=CHOICES["formulation"],
        research=True,
    ),
)
row(
    "port",
    option(
        "--port",
        "Serial port; found by its USB id unless given. `virtual` or `virtual:joints=9` needs no "
        "robot.",
    ),
)
row(
    "figure",
    option("--plot", "figure", "Figure to draw.", type=OutFile(".png", ".pdf", ".svg")),
)


def _ratchet_pair(name: str, text: str) -> float | tuple[float, ...]:
    """Return the number or numbers of a text such as 0.084,0.3; Ground checks how many."""
    numbers = tuple(parsed_number(name, part) for part in text.split(","))
    return numbers[0] if len(numbers) == 1 else numbers


SETTINGS["sizes"] = (
    Setting(
        "links",
        "number of links; each keeps its mass and friction unless these are set too",
        limits=Limits(2, 100_000),
        usual="6",
    ),
    Setting("link_length_m", "length of one link, joint to joint", "m", POSITIVE, "0.076"),
)
SETTINGS["robot"] = (
    *SETTINGS["sizes"],
    Setting("mass_kg", "mass of the whole robot, as it crawls", "kg", POSITIVE, "0.4536"),
    Setting(
        "link_inertia_kg_m2",
        "moment of inertia of one link about its centre",
        "kg m²",
        POSITIVE,
        "a uniform rod's",
    ),
)
SETTINGS["friction"] = (
    Setting(
        "ct",
        "viscous friction along the whole snake; ratchet wheels: forwards,backwards",
        "N s/m",
        NOT_NEGATIVE,
        "0.084",
        _ratchet_pair,
    ),
    Setting("cn", "viscous friction across the whole snake", "N s/m", NOT_NEGATIVE, "1.2"),
    Setting(
        "ft0",
        "dry friction along the whole snake; ratchet wheels: forwards,backwards",
        "N",
        NOT_NEGATIVE,
        "0.14",
        _ratchet_pair,
    ),
    Setting("fn0", "dry friction across the whole snake", "N", NOT_NEGATIVE, "0.27"),
)
SETTINGS["offset"] = (
    Setting("offset_deg", "angle added to every joint, to steer", "deg", Limits(-180, 180), "0"),
)
SETTINGS["springs"] = (
    Setting(
        "joint_stiffness_n_m", "implicit model: stiffness k of the joints", "N/m", POSITIVE, "1000"
    ),
    Setting(
        "joint_damping_n_s_m", "implicit model: damping c of the joints", "N s/m", NOT_NEGATIVE, "1"
    ),
)
SETTINGS["plug"] = (
    Setting(
        "volts", "voltage at the servos' plug", "V", Limits(1, 60), "the session's, or 4.8 to 6"
    ),
    Setting(
        "frame_ms",
        "time between setpoints that the board sends",
        "ms",
        Limits(1, 100),
        "the session's, or 20",
    ),
)
SETTINGS["rtol"] = (Setting("rtol", "relative accuracy of the speed", usual="1e-6"),)


def refuse_springs(settings: Values) -> None:
    """Raise BadInput for settings of springs, which pinned joints do not have."""
    why = "the joints are pinned; give --formulation implicit too"
    refuse_unused(settings, why, "joint_stiffness_n_m", "joint_damping_n_s_m", "gap")


def servo_kind(name: str, settings: Values) -> sn.ServoKind:
    """Return the kind of servo of a name or file, at the voltage and frame time in settings."""
    kind = sn.servo(name)
    if "volts" in settings:
        kind = kind.at_volts(settings["volts"])
    return kind.at_frames(settings["frame_ms"] / 1e3) if "frame_ms" in settings else kind


GAIT = "alpha_deg", "beta_deg", "offset_deg", "frequency_hz", "omega_rad_s"


def make_gait(typed: Values, base: sn.Gait | None = None) -> sn.Gait:
    """Return the gait of typed options and settings; a value of None was not given.

    base: gait whose values, and whose joints' gains and shifts, hold where nothing is given. Raises
    BadInput if there is no base and a value is missing.
    """
    values = {name: typed[name] for name in GAIT if typed.get(name) is not None}
    if "frequency_hz" in values:
        values["hertz"] = values.pop("frequency_hz")
    if base is None:
        rates = values.keys() & {"hertz", "omega_rad_s"}
        if not values.keys() >= {"alpha_deg", "beta_deg"} or len(rates) != 1:
            raise BadInput(
                "give --alpha-deg, --beta-deg, and one of --frequency-hz and --omega-rad-s"
            )
        return sn.Gait.degrees(**values)
    fields = describe(base)
    if "hertz" in values:
        del fields["omega_rad_s"]
    gait = sn.Gait.degrees(**fields | values)
    if not values:
        return base
    return replace(gait, joint_gain=base.joint_gain, joint_shift_rad=base.joint_shift_rad)


def describe(gait: sn.Gait) -> Values:
    """Return a gait's values by the names of the options: angles in deg, rate in rad/s."""
    angles = {name: getattr(gait, name.replace("_deg", "_rad")) for name in GAIT[:3]}
    # Rounding turns 29.999999999999996 into 30.
    degrees = {name: round(math.degrees(angle), 10) for name, angle in angles.items()}
    return degrees | {"omega_rad_s": gait.omega_rad_s}


def busy(what: str, work: Callable[[Callable[[float], object]], T]) -> T:
    """Return work(show_share), and show what is running until it ends.

    what: words for the work. show_share: function that it calls with the share done, 0 to 1. It
    runs in a thread, so that Ctrl-C is noticed while the core computes, and ends the work.
    """
    from concurrent.futures import Future

    from ..base.long_calls import stoppable

    done: Future[T] = Future()
    stop = threading.Event()
    work = stoppable(work, stop)

    def run(show_share: Callable[[float], object]) -> None:
        try:
            done.set_result(work(show_share))
        except BaseException as error:
            done.set_exception(error)

    with working(what) as show_share:
        threading.Thread(target=run, args=(show_share,), daemon=True).start()
        try:
            return done.result()
        finally:
            stop.set()


def print_result(result: Any, as_json: bool, verbose: bool, notes: Values) -> None:
    """Print a result as JSON with the notes of its fit, or as a sentence and a table."""
    from ..show import report

    show_json(result.to_dict() | notes) if as_json else report.show(result, verbose=verbose)


def show_json(values: Values, path: Path | None = None) -> None:
    """Print strict JSON, or write it to a file; NaN and infinity become null."""
    values = json.loads(json.dumps(values), parse_constant=lambda _: None)
    text = json.dumps(values, indent=2)
    say(text) if path is None else write_text(path, text + "\n")


def warn_of_two_motions(state: sn.Steady) -> sn.Steady:
    """Return the state with its `from_rest`; warn if the gait has two stable motions."""
    from ..simulation.from_rest import from_rest, two_motions_text

    state = replace(state, from_rest=busy("starting from rest", lambda _: from_rest(state)))
    if text := two_motions_text(state):
        warnings.warn(text, stacklevel=2)
    return state


@dataclass(frozen=True)
class Snake:
    """A robot on its ground.

    fit: the fit of its friction; None for presets, scenes and changed numbers. session: the session
    that it comes from; None if it comes from elsewhere. notes: remarks on the fit, for JSON.
    """

    robot: sn.Robot
    ground: sn.Ground
    fit: sn.FrictionFit | None = None
    session: sn.Session | None = None
    notes: Values = field(default_factory=dict)


def named_snake(name: str) -> Snake:
    """Return the robot and ground of a preset, a session's folder, a fit.json or a scene.

    "2005" is the robot of the paper's experiment, "paper" that of its theory. A warning says if the
    fit is not to be trusted. Raises BadInput for any other name.
    """
    from ..model.presets import PRESETS

    if name in PRESETS:
        return Snake(*PRESETS[name])
    path = Path(name)
    if path.suffix == ".toml" and path.is_file():
        scene = sn.load_scene(path)
        return Snake(scene.robot, scene.ground)
    session = sn.load_session(path) if path.is_dir() else None
    if session is not None:
        fit = session_fit(session)
    elif path.suffix == ".json":
        fit = sn.load_fit(path)
    else:
        raise BadInput(
            f"--robot is {name!r}; it must be 2005, paper, a session's folder, a fit.json or a "
            "scene (.toml)"
        )
    return Snake(fit.robot, fit.ground, fit, session, warn_of_alarms(fit))


def make_snake(name: str | None, settings: Values, base: Snake | None = None) -> Snake:
    """Return the robot and ground of --robot, else `base`, else 2005, with the numbers of --set.

    Mass and friction are those of the whole robot. If `links` is set alone, each link keeps its
    mass and friction.
    """
    if name is not None or base is None:
        base = named_snake(name or "2005")
    body = group_settings(settings, "robot")
    friction = group_settings(settings, "friction")
    if not body and not friction:
        return base
    old, ground = base.robot, base.ground
    links = body.pop("links", old.links)
    is_rod = old == sn.Robot(old.links, old.link_mass_kg, old.link_length_m)
    sizes = {
        "mass_kg": links * old.link_mass_kg,
        "link_length_m": old.link_length_m,
        "link_inertia_kg_m2": None if is_rod else old.link_inertia_kg_m2,
    }
    robot = sn.Robot.whole_body(links, **(sizes | body))
    if friction:
        frictions = asdict(ground.scaled(*4 * [links]))
        ground = sn.Ground.whole_body(links, **(frictions | friction))
    return replace(base, robot=robot, ground=ground, fit=None)


def session_fit(session: sn.Session) -> sn.FrictionFit:
    """Return the fit in a session's fit.json if its readings are unchanged; else a new fit."""
    from ..friction.file import NAME

    folder = session.folder
    if folder and (folder / NAME).exists():
        try:
            fit = sn.load_fit(folder)
            if fit.session_sha256 == session.sha256:
                return fit
        except sn.BadInput as error:  # An old or edited file; the readings are fitted instead.
            say(f"serpenoid: warning: {error}; fitted anew", err=True)
    return sn.fit_friction(session)


def typed_servo(
    name: str | None, settings: Values, snake: Snake | None = None
) -> sn.ServoKind | None:
    """Return the kind of servo that --servo names; None for ideal joints.

    Without a name it is hobby for short robots, and None for long ones. snake: the robot that the
    servos move. Its session, if any, has their voltage and frame time.
    """
    from ..session.crawls import driving

    if name is None:
        max_links = 20  # Longest robot with servos by default; the time grows as the cube.
        name = IDEAL if snake and snake.robot.links > max_links else "hobby"
    if name.lower() == IDEAL:
        refuse_unused(settings, "joints are ideal; give --servo NAME", "volts", "frame_ms")
        return None
    kind = servo_kind(name, settings)
    if kind.remark:
        say(f"serpenoid: warning: servo {kind.name}: {kind.remark}", err=True)
        if snake:
            snake.notes["servo_remark"] = kind.remark
    return driving(snake.session.setup, kind) if snake and snake.session else kind


def warn_of_alarms(fit: sn.FrictionFit) -> Values:
    """Print why a fit is not to be trusted, and what was not measured; return both for JSON."""
    for alarm in fit.alarms:
        say(f"serpenoid: warning: {alarm}", err=True)
    for note in fit.unmeasured:
        say(f"note: {note}", err=True)
    notes = {"fit_alarms": list(fit.alarms), "fit_notes": fit.unmeasured}
    return {key: words for key, words in notes.items() if words}
