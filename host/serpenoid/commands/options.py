"""What several commands share: options, robot and gait of them, work that Ctrl-C ends, JSON."""

from __future__ import annotations

import json
import math
import re
import threading
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import click

import serpenoid as sn

from ..base.checks import FORMULATIONS, check_number
from ..base.files import write_text
from ..model.capture_rate import HIGHEST_HZ, OPTION
from ..show.screen import say
from .declare import Given, Options, Range, angle, flag, number, option, radians
from .given import ALARMS, take_fit, tell_remark

T = TypeVar("T")
AS_JSON = flag("--json", "as_json", "Answer with JSON.")
CAPTURE_FPS = option(
    OPTION,
    "Pictures a second that the camera took, of slow motion whose file has no tag that says so.",
    type=Range(1, HIGHEST_HZ),
)


def _kept(context: click.Context, option: click.Parameter, value: Any) -> None:
    """Keep an option for what asks for it much later, so that no command has to hand it on."""
    context.meta[f"serpenoid.{option.name}"] = value


# Of a command that answers with tables.
AS_TABLES = Options(
    flag(
        "--verbose",
        "Print errors, margins and other powers, too.",
        callback=_kept,
        expose_value=False,
    ),
    AS_JSON,
)

# Per link: mass kg, full length m, then friction ct, cn (N s/m), ft0, fn0 (N).
PRESETS = {
    "paper": (1.0, 0.12, 0.1, 10.0, 0.0, 0.0),
    "2005": (0.0756, 0.076, 0.084 / 6, 1.2 / 6, 0.14 / 6, 0.27 / 6),
}
ALPHA_DEG, BETA_DEG = (0.0, 180.0), (-360.0, 360.0)  # Gait's limits
_LONG_M, _HEAVY_KG = 3.0, 50.0  # of one link: beyond what anybody puts on wheels
_FAST_RAD_S = 60.0  # ten waves a second


def both_ways(value: str) -> float | tuple[float, ...]:
    """Read one number, or two for ratchet wheels: forwards,backwards; Ground says which may be."""
    try:
        numbers = tuple(float(part) for part in value.split(","))
    except ValueError:
        raise click.BadParameter(f"{value!r} is no number, nor two (forwards,backwards)") from None
    return numbers[0] if len(numbers) == 1 else numbers


BOTH_WAYS = click.types.FuncParamType(both_ways)
BOTH_WAYS.name = "N[,N]"  # as help has it


def _listed(_ctx: click.Context, _option: click.Parameter, gaits: Any) -> list[sn.Gait]:

    return [
        sn.Gait(
            radians("--gait ALPHA_DEG", alpha_deg, *ALPHA_DEG),
            radians("--gait BETA_DEG", beta_deg, *BETA_DEG),
            math.tau * check_number("--gait HZ", hertz, 0.0, open_low=True),
        )
        for alpha_deg, beta_deg, hertz in gaits
    ]


listed_gaits = number(
    "--gait",
    "gaits",
    "A gait to predict, beside the session's.",
    nargs=3,
    multiple=True,
    metavar="ALPHA_DEG BETA_DEG HZ",
    callback=_listed,
)
formulation_option = option(
    "--formulation", "Exact model, or the paper's springs.", choice=FORMULATIONS, default="explicit"
)
fit_options = Options(
    option(
        "--session",
        "Calibration session whose robot and fitted friction to take.",
        type=click.Path(path_type=Path),
    ),
    option(
        "--ground",
        "ground_file",
        "fit.json whose robot and friction to take.",
        type=click.Path(path_type=Path),
    ),
)

ROBOT = Options(
    option("--links", "Number of links; 6 unless given.", type=int),
    number("--mass-kg", "link_mass_kg", "Mass of a link."),
    number("--length-m", "link_length_m", "Length of a link, joint to joint."),
    number("--inertia-kg-m2", "link_inertia_kg_m2", "Of a link; a uniform rod's unless given."),
)
GROUND = Options(
    option(
        "--ct", "Viscous friction along a link, N s/m; ratchet: forwards,backwards.", type=BOTH_WAYS
    ),
    number("--cn", "Viscous friction across a link, N s/m."),
    option("--ft0", "Dry friction along a link, N; ratchet: forwards,backwards.", type=BOTH_WAYS),
    number("--fn0", "Dry friction across a link, N."),
)
robot_options = Options(
    option(
        "--robot", "preset", "Robot and ground to start from; 2005 unless given.", choice=PRESETS
    ),
    fit_options,
    ROBOT,
    GROUND,
)

gait_options = Options(
    angle("--alpha-deg", "Amplitude of the joints.", low=ALPHA_DEG[0], high=ALPHA_DEG[1]),
    angle("--beta-deg", "Phase lag joint to joint.", low=BETA_DEG[0], high=BETA_DEG[1]),
    number("--omega-rad-s", "Angular rate; or give --frequency-hz."),
    number("--frequency-hz", "Gait frequency."),
    angle("--offset-deg", "Bend of every joint: steers.", low=-180.0, high=180.0),
)

plug_options = Options(
    option(
        "--volts",
        "Voltage at the servos' plug; else the session's, or 4.8 to 6 V.",
        type=Range(1.0, 60.0),
        callback=_kept,
        expose_value=False,
    ),
    option(
        "--frame-ms",
        "From setpoint to setpoint of the board; else the session's, or 20 ms.",
        type=Range(1.0, 100.0),
        callback=_kept,
        expose_value=False,
    ),
)
servo_option = Options(
    option(
        "--servo",
        "Servos of the joints: hobby (any), SG90, MG996R, ..., a TOML file, or ideal.",
        metavar="NAME|FILE|ideal",
        callback=_kept,
        expose_value=False,
    ),
    plug_options,
)
IDEAL = "ideal"


def typed(option: str) -> Any:
    """Return the value of an option that was kept, None where it was not given."""
    return click.get_current_context().meta.get(f"serpenoid.{option}")


def take_servo(default: str = IDEAL) -> sn.ServoKind | None:
    """Return the servo of --servo, --volts and --frame-ms; None for joints that follow the gait."""
    name, volts, frame_ms = map(typed, ("servo", "volts", "frame_ms"))
    wanted = default if name is None else name
    if wanted.lower() == IDEAL:
        if volts or frame_ms:
            raise click.UsageError("--volts and --frame-ms need servos: give --servo NAME")
        return None

    kind = sn.servo(wanted)
    tell_remark(kind)
    kind = kind if volts is None else kind.at_volts(volts)
    return kind if frame_ms is None else kind.at_frames(frame_ms / 1e3)


def preset_robot(name: str) -> tuple[sn.Robot, sn.Ground]:
    """Return robot and ground of a preset."""
    mass, length, *friction = PRESETS[name]
    return sn.Robot(6, mass, length), sn.Ground(*friction)


def make_robot(
    given: Given,
    base: tuple[sn.Robot, sn.Ground] | None = None,
    fit: sn.FrictionFit | None = None,
) -> tuple[sn.Robot, sn.Ground]:
    """Take robot and ground from the preset, a fit, or else `base`, and what overrides it.

    fit: one that has been taken already.
    """
    fit = fit or take_fit(given)
    doubt_robot(given)
    preset = given.pop("preset")
    if fit is not None:
        if preset is not None:
            raise click.UsageError("--robot and a fit both name robot and ground; give one of them")
        base = fit.robot, fit.ground
    if preset is not None or base is None:
        base = preset_robot(preset or "2005")
    robot, ground = base
    changes = ROBOT.take(given)
    if robot == sn.Robot(robot.links, robot.link_mass_kg, robot.link_length_m):
        changes.setdefault("link_inertia_kg_m2", None)  # a uniform rod stays one
    return replace(robot, **changes), replace(ground, **GROUND.take(given))


def make_gait(given: Given, base: sn.Gait | None = None) -> sn.Gait:
    """Take a gait with either rate or frequency, over `base` if there is one."""
    fields = gait_options.take(given)
    # Figures that look as if typed in another unit are told, not refused: they may be meant.
    alpha, beta = (math.degrees(fields.get(name, 0.0)) for name in ("alpha_rad", "beta_rad"))
    if alpha and beta and 0 < alpha <= math.pi and abs(beta) <= math.pi:
        words = f"{alpha:g} and {beta:g} degrees"
        _tell("--alpha-deg, --beta-deg", words, "radians", math.degrees(alpha), math.degrees(beta))
    omega = fields.get("omega_rad_s", 0.0)
    if _FAST_RAD_S < omega < math.inf:
        words = f"{omega:g} rad/s, {omega / math.tau:.3g} waves a second"
        _tell("--omega-rad-s", words, "degrees a second", math.radians(omega))
    rates = [name for name in ("omega_rad_s", "frequency_hz") if name in fields]
    if len(rates) > 1 or not (rates or base):
        raise click.UsageError("give one of --omega-rad-s and --frequency-hz")
    if "frequency_hz" in fields:
        hertz = check_number("--frequency-hz", fields.pop("frequency_hz"), 0.0, open_low=True)
        fields["omega_rad_s"] = math.tau * hertz
    if base is not None:
        return replace(base, **fields)
    for name in ("alpha", "beta"):
        if f"{name}_rad" not in fields:
            raise click.UsageError(f"give --{name}-deg")
    return sn.Gait(**fields)


def doubt_robot(given: Mapping[str, Any], names: str = "--{}") -> None:
    """Warn of links whose length or mass, where given, looks like mm or g."""
    for name, most, unit, small in (
        ("length_m", _LONG_M, "m", "mm"),
        ("mass_kg", _HEAVY_KG, "kg", "g"),
    ):
        value = given.get(f"link_{name}")
        if value is not None and most < value < math.inf:
            option = names.format(name.replace("_", "-"))
            _tell(option, f"{value:g} {unit} for one link", small, value / 1e3)


def _tell(option: str, value: str, unit: str, *meant: float) -> None:
    typed = " and ".join(f"{number:.4g}" for number in meant)
    warnings.warn(f"{option}: {value}? If {unit} were meant, type {typed}", stacklevel=2)


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


def describe(gait: sn.Gait) -> Given:
    """Return a gait as it is typed."""
    return {
        "alpha_deg": round(math.degrees(gait.alpha_rad), 10),  # 30, not 29.999999999999996
        "beta_deg": round(math.degrees(gait.beta_rad), 10),
        "omega_rad_s": gait.omega_rad_s,
        "offset_deg": round(math.degrees(gait.offset_rad), 10),
    } | ({"joint_gain": list(gait.joint_gain)} if gait.joint_gain else {})


def tell(found: Any, as_json: bool) -> None:
    """Print a result: as JSON, or what a builder asks and then its table."""
    from ..show import report

    if as_json:
        return show_json(found.to_dict())
    return report.show(found)


def finite(values: Any) -> Any:
    """Return plain values with everything that is not finite as None, for strict JSON."""
    if isinstance(values, dict):
        return {key: finite(value) for key, value in values.items()}
    if isinstance(values, (list, tuple)):
        return [finite(value) for value in values]
    if isinstance(values, float) and not math.isfinite(values):
        return None
    return values


def json_text(values: Given) -> str:
    """Return strict JSON; what is not finite becomes null."""
    return json.dumps(finite(values), indent=2, allow_nan=False)


def write_json(path: Path, values: Given) -> None:
    """Write strict JSON into a file."""
    write_text(path, json_text(values) + "\n")


def show_json(values: Given) -> None:
    """Print strict JSON, with alarms and notes of its fit."""
    context = click.get_current_context(silent=True)
    say(json_text(values | (context.meta.get(ALARMS, {}) if context else {})))


def as_typed(text: str, options: dict[str, str]) -> str:
    """Return a message with the names of fields replaced by their options.

    A name of several words is meant wherever it stands, but for arguments such as `alpha_rad=1`;
    one of one word (links, ct) only where the message begins with `ct is`.
    """
    for field, typed in options.items():
        if "_" in field:
            text = re.sub(rf"(?<![\w.-]){field}(?![\w=])", typed, text)
        else:
            text = re.sub(rf"^{field}((?: \w+)?) is ", rf"{typed}\1 is ", text)
    return text


def options_of(command: click.Command) -> dict[str, str]:
    """Return the options of a command by the fields that they fill."""
    return {p.name: p.opts[0] for p in command.params if isinstance(p, click.Option) and p.name}


def warn_of_two_motions(state: sn.Steady) -> sn.Steady:
    """Return the state with where a start from rest leads; warn where there are two motions."""
    from ..simulation.from_rest import from_rest, two_motions_text

    state = replace(state, from_rest=interruptible(lambda: from_rest(state)))
    if text := two_motions_text(state):
        warnings.warn(text, stacklevel=2)
    return state
