"""The table of options that several commands have, and what they make: robot, gait, servo, JSON."""

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

from ..base.checks import FORMULATIONS, NOT_NEGATIVE, POSITIVE, Limits
from ..base.errors import BadInput
from ..base.files import write_text
from ..model.capture_rate import OPTION
from ..show.screen import say, working
from .declare import (
    FIGURES,
    FOLDER,
    OutFile,
    Setting,
    Values,
    chosen,
    flag,
    number,
    option,
    parsed_number,
    refuse_unused,
    row,
)

T = TypeVar("T")
IDEAL = "ideal"
AS_JSON = flag("--json", "as_json", "Answer with JSON.")
CAPTURE_FPS = number(
    OPTION,
    "Pictures a second that the camera took, of slow motion whose file has no tag that says so.",
)


def _listed(_ctx: click.Context, _option: click.Parameter, gaits: Any) -> list[sn.Gait]:
    return [sn.Gait.degrees(alpha, beta, hertz=hertz) for alpha, beta, hertz in gaits]


row("as_json", AS_JSON)
row("verbose", flag("--verbose", "Print errors, margins and other powers, too."))
row("capture_fps", CAPTURE_FPS)
row("session", click.argument("session", type=FOLDER))
row(
    "robot",
    option(
        "--robot",
        "Robot and friction: 2005 (the paper's real one, unless given), paper (the one of its "
        "theory), a session's folder, a fit.json, or a scene (.toml).",
        metavar="2005|paper|FILE|SESSION",
    ),
)
row(
    "typed_gait",
    number("--alpha-deg", "Amplitude of the joints."),
    number("--beta-deg", "Phase lag from joint to joint."),
    number("--frequency-hz", "Frequency of the gait."),
    number("--omega-rad-s", "Its angular rate, in place of the frequency."),
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
        callback=_listed,
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
        "Exact model (explicit, unless given), or the paper's springs.",
        choice=FORMULATIONS,
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
row("figure", option("--plot", "figure", "PNG, PDF or SVG to draw.", type=OutFile(*FIGURES)))


def _both_ways(name: str, text: str) -> float | tuple[float, ...]:
    """Read one number, or two for ratchet wheels: forwards,backwards; Ground says which may be."""
    numbers = tuple(parsed_number(name, part) for part in text.split(","))
    return numbers[0] if len(numbers) == 1 else numbers


ROBOT = (
    Setting(
        "links",
        "number of links; more or fewer of the same, unless mass and friction are set too",
        limits=Limits(2, 100_000),
        usual="6",
    ),
    Setting("mass_kg", "mass of the whole robot, as it crawls", "kg", POSITIVE, "0.4536"),
    Setting("link_length_m", "length of one link, joint to joint", "m", POSITIVE, "0.076"),
    Setting(
        "link_inertia_kg_m2",
        "moment of inertia of one link about its centre",
        "kg m²",
        POSITIVE,
        "a uniform rod's",
    ),
)
RATCHET = "ratchet wheels: forwards,backwards"
FRICTION = (
    Setting(
        "ct", f"viscous, along the snake; {RATCHET}", "N s/m", NOT_NEGATIVE, "0.084", _both_ways
    ),
    Setting("cn", "viscous friction across the whole snake", "N s/m", NOT_NEGATIVE, "1.2"),
    Setting("ft0", f"dry, along the snake; {RATCHET}", "N", NOT_NEGATIVE, "0.14", _both_ways),
    Setting("fn0", "dry friction across the whole snake", "N", NOT_NEGATIVE, "0.27"),
)
OFFSET = Setting("offset_deg", "bend of every joint: steers", "deg", Limits(-180, 180), "0")
SPRINGS = (
    Setting("joint_stiffness_n_m", "implicit model: k of the joints", "N/m", POSITIVE, "1000"),
    Setting("joint_damping_n_s_m", "implicit model: c of the joints", "N s/m", NOT_NEGATIVE, "1"),
)
PINNED = "the joints are pinned; give --formulation implicit too"
PLUG = (
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
RTOL = Setting("rtol", "relative accuracy of the speed", usual="1e-6")


def servo_kind(name: str, settings: Values) -> sn.ServoKind:
    """Return servos of a name or file, at the plug's settings."""
    kind = sn.servo(name)
    if "volts" in settings:
        kind = kind.at_volts(settings["volts"])
    return kind.at_frames(settings["frame_ms"] / 1e3) if "frame_ms" in settings else kind


GAIT = "alpha_deg", "beta_deg", "offset_deg", "frequency_hz", "omega_rad_s"


def make_gait(typed: Values, base: sn.Gait | None = None) -> sn.Gait:
    """Return the gait of typed options and settings (None: not given), over `base` if there is one.

    Its joints have the gains and shifts of the base.
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
    """Return a gait as it is typed."""
    angles = {name: getattr(gait, name.replace("_deg", "_rad")) for name in GAIT[:3]}
    degrees = {
        name: round(math.degrees(angle), 10) for name, angle in angles.items()
    }  # 30, not 29.99
    return degrees | {"omega_rad_s": gait.omega_rad_s}


def interruptible(work: Callable[[], T]) -> T:
    """Return work(), run in a thread: Python hears Ctrl-C only while it is not in the core."""
    from concurrent.futures import Future

    from ..base.long_calls import stoppable

    done: Future[T] = Future()
    stop = threading.Event()
    work = stoppable(work, stop)

    def run() -> None:
        try:
            done.set_result(work())
        except BaseException as error:
            done.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    try:
        return done.result()
    finally:
        stop.set()


def busy(what: str, work: Callable[[Callable[[float], object]], T]) -> T:
    """Return work(), which takes what shows the share of it that is done, and show that it goes on.

    Ctrl-C ends both, so this thread shows it.
    """
    with working(what) as show_share:
        return interruptible(lambda: work(show_share))


def tell(result: Any, as_json: bool, verbose: bool, notes: Values) -> None:
    """Print a result: as JSON with the notes of its fit, or its first sentence and its table."""
    from ..show import report

    show_json(result.to_dict() | notes) if as_json else report.show(result, verbose=verbose)


def show_json(values: Values, path: Path | None = None) -> None:
    """Print strict JSON, or write it into a file; what is not finite becomes null."""
    values = json.loads(json.dumps(values), parse_constant=lambda _: None)
    text = json.dumps(values, indent=2)
    say(text) if path is None else write_text(path, text + "\n")


def warn_of_two_motions(state: sn.Steady) -> sn.Steady:
    """Return the state with where a start from rest leads; warn where there are two motions."""
    from ..simulation.from_rest import from_rest, two_motions_text

    state = replace(state, from_rest=interruptible(lambda: from_rest(state)))
    if text := two_motions_text(state):
        warnings.warn(text, stacklevel=2)
    return state


@dataclass(frozen=True)
class Snake:
    """A robot on its ground.

    fit: whose friction it is; None of a preset, of a scene, and where a number of it was changed.
    session: that it came from, if it did. notes: of its fit, for JSON.
    """

    robot: sn.Robot
    ground: sn.Ground
    fit: sn.FrictionFit | None = None
    session: sn.Session | None = None
    notes: Values = field(default_factory=dict)


def named_snake(name: str) -> Snake:
    """Return the robot and ground of a preset, a session's folder, a fit.json or a scene.

    "2005" is the robot of the paper's experiment, "paper" that of its theory. What forbids to trust
    a fit is told. Raises BadInput for a name that is none of these.
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
    return Snake(fit.robot, fit.ground, fit, session, tell_alarms(fit))


def make_snake(name: str | None, settings: Values, base: Snake | None = None) -> Snake:
    """Return the robot and ground of --robot, else `base`, else 2005, with the numbers of --set.

    Mass and friction are those of the whole robot. Where `links` alone is set, every link keeps
    its own.
    """
    if name is not None or base is None:
        base = named_snake(name or "2005")
    body = chosen(settings, *ROBOT)
    friction = chosen(settings, *FRICTION)
    if not body and not friction:
        return base
    old, ground = base.robot, base.ground
    links = body.pop("links", old.links)
    rod = old == sn.Robot(old.links, old.link_mass_kg, old.link_length_m)  # a rod stays one
    sizes = {
        "mass_kg": links * old.link_mass_kg,
        "link_length_m": old.link_length_m,
        "link_inertia_kg_m2": None if rod else old.link_inertia_kg_m2,
    }
    robot = sn.Robot.whole_body(links, **(sizes | body))
    if friction:
        frictions = asdict(ground.scaled(*4 * [links]))
        ground = sn.Ground.whole_body(links, **(frictions | friction))
    return replace(base, robot=robot, ground=ground, fit=None)


def session_fit(session: sn.Session) -> sn.FrictionFit:
    """Return a session's fit.json if it is that of its readings, else fit them now."""
    from ..friction.file import NAME, rests_on

    folder = session.folder
    if folder and (folder / NAME).exists():
        try:
            fit = sn.load_fit(folder)
            if rests_on(fit, session):
                return fit
        except sn.BadInput as error:  # an older version's, or edited: the readings are there
            say(f"serpenoid: warning: {error}; fitted anew", err=True)
    return sn.fit_friction(session)


MOST_LINKS = 20  # Links with hobby servos unasked: the work grows as the cube of the links.


def take_servo(
    name: str | None, settings: Values, snake: Snake | None = None
) -> sn.ServoKind | None:
    """Return the servos of a name, hobby servos unless given; None for joints that are ideal.

    snake: the robot that they move; a session has their voltage and the frames of its board.
    """
    from ..session.crawls import driving

    if name is None:
        name = IDEAL if snake and snake.robot.links > MOST_LINKS else "hobby"
    if name.lower() == IDEAL:
        refuse_unused(settings, "joints are ideal; give --servo NAME", "volts", "frame_ms")
        return None
    kind = servo_kind(name, settings)
    if kind.remark:
        say(f"serpenoid: warning: servo {kind.name}: {kind.remark}", err=True)
        if snake:
            snake.notes["servo_remark"] = kind.remark
    return driving(snake.session.setup, kind) if snake and snake.session else kind


def tell_alarms(fit: sn.FrictionFit) -> Values:
    """Warn of what forbids to trust a fit, note what was not measured; return both for JSON."""
    for alarm in fit.alarms:
        say(f"serpenoid: warning: {alarm}", err=True)
    for note in fit.unmeasured:
        say(f"note: {note}", err=True)
    notes = {"fit_alarms": list(fit.alarms), "fit_notes": fit.unmeasured}
    return {key: words for key, words in notes.items() if words}
