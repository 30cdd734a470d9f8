"""Options that several commands have, what they make (robot, gait, servo), and JSON answers."""

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
from ..model.capture_rate import HIGHEST_HZ, OPTION
from ..show.screen import say, working
from .declare import (
    Setting,
    Values,
    chosen,
    flag,
    number,
    option,
    parsed_number,
    refuse_unused,
    together,
)

T = TypeVar("T")
AS_JSON = flag("--json", "as_json", "Answer with JSON.")
AS_TABLES = together(flag("--verbose", "Print errors, margins and other powers, too."), AS_JSON)
CAPTURE_FPS = number(
    OPTION,
    "Pictures a second that the camera took, of slow motion whose file has no tag that says so.",
    limits=Limits(1, HIGHEST_HZ),
)


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

robot_option = option(
    "--robot",
    "Robot and friction: 2005 (the paper's real one, unless given), paper (the one of its theory), "
    "a session's folder, a fit.json, or a scene (.toml).",
    metavar="2005|paper|FILE|SESSION",
)
gait_options = together(
    number("--alpha-deg", "Amplitude of the joints."),
    number("--beta-deg", "Phase lag from joint to joint."),
    number("--frequency-hz", "Frequency of the gait.", limits=POSITIVE),
    number("--omega-rad-s", "Its angular rate, in place of the frequency."),
)
servo_option = option(
    "--servo",
    "Servos of the joints: hobby (any), SG90, MG996R, ..., a TOML file, or ideal.",
    metavar="NAME|FILE|ideal",
)
formulation_option = option(
    "--formulation",
    "Exact model, or the paper's springs.",
    choice=FORMULATIONS,
    default="explicit",
    research=True,
)
IDEAL = "ideal"


def _listed(_ctx: click.Context, _option: click.Parameter, gaits: Any) -> list[sn.Gait]:
    return [sn.Gait.degrees(alpha, beta, hertz=hertz) for alpha, beta, hertz in gaits]


listed_gaits = number(
    "--gait",
    "gaits",
    "A gait to predict, beside the session's.",
    nargs=3,
    multiple=True,
    metavar="ALPHA_DEG BETA_DEG HZ",
    callback=_listed,
)


def servo_kind(name: str, settings: Values) -> sn.ServoKind:
    """Return servos of a name or file, at the plug's settings."""
    kind = sn.servo(name)
    if "volts" in settings:
        kind = kind.at_volts(settings["volts"])
    return kind.at_frames(settings["frame_ms"] / 1e3) if "frame_ms" in settings else kind


GAIT_FIELDS = {  # name that is typed -> field of Gait
    "alpha_deg": "alpha_rad",
    "beta_deg": "beta_rad",
    "offset_deg": "offset_rad",
    "frequency_hz": "omega_rad_s",
    "omega_rad_s": "omega_rad_s",
}


def make_gait(typed: Values, settings: Values, base: sn.Gait | None = None) -> sn.Gait:
    """Return the gait of `gait_options` and of offset_deg, over `base` if there is one.

    typed: the values of the options by name; those that are None were not given.
    """
    values = {name: v for name, v in (settings | typed).items() if name in GAIT_FIELDS}
    values = {name: value for name, value in values.items() if value is not None}
    rates = values.keys() & {"frequency_hz", "omega_rad_s"}
    complete = base or (rates and values.keys() >= {"alpha_deg", "beta_deg"})
    if len(rates) > 1 or not complete:
        raise BadInput("give --alpha-deg, --beta-deg, and one of --frequency-hz and --omega-rad-s")
    angles = {name: values.get(name, 0.0) for name in ("alpha_deg", "beta_deg", "offset_deg")}
    shape = sn.Gait.degrees(**angles, hertz=values.get("frequency_hz", 1.0))
    fields = {GAIT_FIELDS[name]: getattr(shape, GAIT_FIELDS[name]) for name in values}
    if "omega_rad_s" in values:
        fields["omega_rad_s"] = values["omega_rad_s"]
    return replace(base or shape, **fields)


def describe(gait: sn.Gait) -> Values:
    """Return a gait as it is typed."""
    return {
        "alpha_deg": round(math.degrees(gait.alpha_rad), 10),  # 30, not 29.999999999999996
        "beta_deg": round(math.degrees(gait.beta_rad), 10),
        "omega_rad_s": gait.omega_rad_s,
        "offset_deg": round(math.degrees(gait.offset_rad), 10),
    } | ({"joint_gain": list(gait.joint_gain)} if gait.joint_gain else {})


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


def finite(values: Any) -> Any:
    """Return plain values with everything that is not finite as None, for strict JSON."""
    if isinstance(values, dict):
        return {key: finite(value) for key, value in values.items()}
    if isinstance(values, (list, tuple)):
        return [finite(value) for value in values]
    return None if isinstance(values, float) and not math.isfinite(values) else values


def show_json(values: Values, path: Path | None = None) -> None:
    """Print strict JSON, or write it into a file; what is not finite becomes null."""
    text = json.dumps(finite(values), indent=2, allow_nan=False)
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


def preset(name: str) -> Snake:
    """Return the robot of the paper's experiment, "2005", or of its theory, "paper"."""
    if name == "paper":
        return Snake(sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0))
    robot = sn.Robot(6, 0.0756, 0.076)
    return Snake(robot, sn.Ground.whole_body(6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27))


def named_snake(name: str) -> Snake:
    """Return the robot and ground of a preset, a session's folder, a fit.json or a scene.

    What forbids to trust a fit is told. Raises BadInput for a name that is none of these.
    """
    if name in ("2005", "paper"):
        return preset(name)
    path = Path(name)
    if path.suffix == ".toml" and path.is_file():
        scene = sn.load_scene(path)
        return Snake(scene.robot, scene.ground)
    session = sn.load_session(path) if path.is_dir() else None
    if session is not None:
        fit = session_fit(session)
    elif path.suffix == ".json":
        fit = tell_alarms(sn.load_fit(path))
    else:
        raise BadInput(
            f"--robot is {name!r}; it must be 2005, paper, a session's folder, a fit.json or a "
            "scene (.toml)"
        )
    return Snake(fit.robot, fit.ground, fit, session, alarms_of(fit))


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
                return tell_alarms(fit)
        except sn.BadInput as error:  # an older version's, or edited: the readings are there
            say(f"serpenoid: warning: {error}; fitted anew", err=True)
    return tell_alarms(sn.fit_friction(session))


def take_servo(name: str, settings: Values, snake: Snake | None = None) -> sn.ServoKind | None:
    """Return the servos of a name; None for joints that are ideal.

    snake: of a session, which has their voltage and the frames of its board.
    """
    from ..session.crawls import driving

    if name.lower() == IDEAL:
        refuse_unused(settings, "joints are ideal; give --servo NAME", "volts", "frame_ms")
        return None
    kind = servo_kind(name, settings)
    if kind.remark:
        say(f"serpenoid: warning: servo {kind.name}: {kind.remark}", err=True)
        if snake:
            snake.notes["servo_remark"] = kind.remark
    return driving(snake.session.setup, kind) if snake and snake.session else kind


def tell_alarms(fit: sn.FrictionFit) -> sn.FrictionFit:
    """Warn of what forbids to trust a fit, note what was not measured; return the fit."""
    notes = alarms_of(fit)
    for alarm in notes.get("fit_alarms", ()):
        say(f"serpenoid: warning: {alarm}", err=True)
    for note in notes.get("fit_notes", ()):
        say(f"note: {note}", err=True)
    return fit


def alarms_of(fit: sn.FrictionFit) -> Values:
    """Return what forbids to trust a fit and what was not measured, as JSON answers have it."""
    old = [note for note in fit.notes if "is older than the readings" in note]
    notes = {"fit_alarms": [*fit.alarms, *old], "fit_notes": fit.unmeasured}
    return {key: words for key, words in notes.items() if words}
