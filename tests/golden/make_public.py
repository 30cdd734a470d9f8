"""Write public.txt, a list of all public names: a change of it needs a line in CHANGELOG.md.

Commands and options, keys of --json and of files that people keep, Python's signatures.
"""

from __future__ import annotations

import dataclasses
import inspect
import json
import os
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import click
import serpenoid as sn
from click.testing import CliRunner
from serpenoid.base import errors
from serpenoid.commands.main import cli
from serpenoid.robot import RobotBoard
from serpenoid.robot.recording.stream import load_stream
from serpenoid.servos import bench_fit

PATH = Path(__file__).resolve().with_name("public.txt")
ROOT = PATH.parents[2]
PATHS = {  # words in ANSWERS that stand for a path
    "DIR": ROOT / "calibration_data" / "nirakh-2005",
    "SCENE": ROOT / "host" / "examples" / "limping_on_a_slope.toml",
    "FILM": ROOT / "calibration_data" / "demo-film" / "film.mp4",
}
GAIT = "--alpha-deg 70 --beta-deg 75 --omega-rad-s 5"
GRID = "--alpha-deg 60:70:10 --beta-deg 75 --omega-rad-s 5"
THREE_LINKS = (
    "--set links=3 --set mass_kg=0.3 --set link_length_m=0.1 "
    "--set ct=0.03 --set cn=3 --set ft0=0 --set fn0=0"
)
NEW_GAIT = "--gait 70 75 0.5 --set samples=16"
# Commands with an answer in JSON. make_inputs() writes MINE, a session with a crawl, and BENCH,
# a bench test of a servo.
ANSWERS = (
    f"steady {GAIT} --servo ideal",
    f"steady {GAIT} --formulation implicit",
    f"steady {GAIT} --robot DIR --sensitivities",
    f"sweep {GRID}",
    f"sweep {GAIT} --servo SG90",
    f"optimize {THREE_LINKS} --speed-m-s 0.03",
    "optimize --robot DIR --speed-m-s 0.03 --servo ideal",
    "simulate --scene SCENE --duration-s 0.5",
    "fit DIR",
    "fit MINE",
    f"compare DIR {NEW_GAIT}",
    f"advise DIR {NEW_GAIT}",
    "calibrate status MINE",
    "servo --test BENCH",
    "video FILM",
    f"drive --port virtual:fast {GAIT} --duration-s 1",
    "doctor --port virtual:fast --listen-s 1",
)
# Angle of the bend in degrees, incline in degrees, speed of the belt in m/s.
STATIONS = ((0, 2.02, 0.2), (0, 2.66, 0.8), (25, 3.02, 0.2), (25, 4.4, 0.8))
CRAWL = "gait alpha_deg=70 beta_deg=75 distance_m=2.5 duration_s=20 omega_rad_s=5"
READING_KINDS = ("station", "bend", "zero", "belt", "gait", "video", "push")
UNKNOWN_KEY = "zzzz"  # the error message for it lists the known keys


def run(line: str) -> str:
    """Return the standard output of a command."""
    result = CliRunner().invoke(cli, [str(PATHS.get(word, word)) for word in line.split()])
    if result.exit_code:
        raise SystemExit(f"serpenoid {line}: {result.output} {result.exception}")
    return result.stdout


def commands(group: click.Group, words: str = "serpenoid") -> Iterator[str]:
    """Yield a line for every command, then lines for its arguments and options."""
    for name, command in sorted(group.commands.items()):
        yield f"{words} {name}"
        yield from sorted(f"    {option(parameter)}" for parameter in command.params)
        if isinstance(command, click.Group):
            yield from commands(command, f"{words} {name}")


def option(p: click.Parameter) -> str:
    """Return the names of an option, its type, limits or choices, and its default."""
    kind = p.type.name
    if isinstance(p.type, click.Choice):
        kind = "|".join(map(str, p.type.choices))
    if limits := getattr(p.type, "limits", None):
        kind += f" {limits.low}..{limits.high}"
    kind += "".join(f" {name}" for name in getattr(p.type, "known", ()))
    names, default = "/".join([*p.opts, *p.secondary_opts]), p.to_info_dict()["default"]
    marks = [kind, f"{p.nargs} words" * (p.nargs > 1), "any number" * (p.nargs < 0 or p.multiple)]
    marks += ["required" * p.required, f"default {default}" * (default not in (None, False, ""))]
    return f"{names}: {', '.join(filter(None, marks))}"


def keys(value: Any, path: str = "") -> Iterator[str]:
    """Yield every key of an answer; `[]` stands for each item of a list."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from keys(inner, f"{path}.{name}" if path else name)
    elif isinstance(value, list) and any(isinstance(item, (dict, list)) for item in value):
        for item in value:
            yield from keys(item, f"{path}[]")
    else:
        yield path


def keys_by_table(answer: Any) -> list[str]:
    """Return the keys of an answer, one line for each table in it."""
    parents: dict[str, set[str]] = {}
    for key in keys(answer):
        parent, _, name = re.sub(r"\[\d+\]", "[]", key).rpartition(".")
        parents.setdefault(parent or "top", set()).add(name)
    return [f"{parent}: {' '.join(sorted(names))}" for parent, names in sorted(parents.items())]


def listed_names(refusal: object) -> str:
    """Return the known names that an error message lists, sorted."""
    listed = re.search(r"(?:known are|of kind \w+ has) (.+)$", str(refusal))
    if not listed:
        raise SystemExit(f"this lists no names: {refusal}")
    return " ".join(sorted(listed[1].replace(" (or ", ", or_").replace(")", "").split(", ")))


def table_keys(path: Path, load: Callable[[Path], object]) -> Iterator[str]:
    """Yield each table of a TOML file with the keys that it may have."""
    text = path.read_text()
    for head in ("format", *re.findall(r"^\[\w+\]", text, re.M)):
        path.write_text(
            re.sub(rf"^{re.escape(head)}.*", rf"\g<0>\n{UNKNOWN_KEY} = 1", text, flags=re.M)
        )
        try:
            load(path)
        except sn.BadInput as error:
            yield f"{head.replace('format', 'top')}: {listed_names(error)}"
    path.write_text(text)


def scene_keys() -> Iterator[str]:
    """Yield the tables of a scene's file."""
    parts = sn.Robot(6, 0.0756, 0.076), sn.Ground(0.01, 0.2, 0.0, 0.0), sn.Gait(1.0, 1.0, 5.0)
    servo = sn.Scene(*parts, drive="servo", servo=sn.servo("SG90").servo, locked={1: 0.1})
    sn.save_scene(servo, "scene.toml")
    text = Path("scene.toml").read_text().replace("[locked_rad]", "#").replace("\n1 =", "\n#")
    Path("scene.toml").write_text(text)
    yield from table_keys(Path("scene.toml"), sn.load_scene)
    torque = sn.TorqueTable([0.0, 1.0], [[0.0] * 5] * 2)
    sn.save_scene(sn.Scene(*parts, drive="torque", torque=torque), "scene.toml")
    yield from table_keys(Path("scene.toml"), sn.load_scene)


def session_keys() -> Iterator[str]:
    """Yield the tables of session.toml, columns of the files beside it, and kinds of readings."""
    yield from table_keys(Path("MINE", "session.toml"), lambda path: sn.load_session(path.parent))
    for name in ("readings.csv", "events.csv"):
        header = Path("MINE", name).read_text().split("\n", 1)[0]
        yield f"{name}: {header.replace(',', ' ')}"
    for kind in READING_KINDS:
        refused = CliRunner().invoke(cli, ["calibrate", "add", "MINE", kind, f"{UNKNOWN_KEY}=1"])
        yield f"kind {kind}: {listed_names(refused.exception)}"


def python_names() -> Iterator[str]:
    """Yield the public names of Python, with their parameters and members."""
    public = {f"serpenoid.base.errors.{n}": v for n, v in vars(errors).items() if is_ours(v)}
    public |= {f"sn.{name}": getattr(sn, name) for name in sn.__all__}
    public["serpenoid.robot.RobotBoard"] = RobotBoard
    public["serpenoid.robot.recording.stream.load_stream"] = load_stream
    for name, value in sorted(public.items()):
        if isinstance(value, type) and issubclass(value, Exception):
            yield f"{name}: {' '.join(base.__name__ for base in value.__bases__)}"
        else:
            yield f"{name}{parameters(value)}"
            yield from members(value) if isinstance(value, type) else ()


def is_ours(value: object) -> bool:
    """Tell whether this package defines it."""
    return getattr(value, "__module__", "").startswith("serpenoid.")


def members(kind: type) -> list[str]:
    """Return fields, properties and methods that a class of this package has."""
    public = (
        {f.name: "" for f in dataclasses.fields(kind)} if dataclasses.is_dataclass(kind) else {}
    )
    for base in filter(is_ours, kind.__mro__):
        public |= {n: parameters(v) for n, v in vars(base).items() if n not in public}
    return sorted(f"    {name}{signature}" for name, signature in public.items() if name[0] != "_")


def parameters(value: Any) -> str:
    """Return the parameters of a callable with their defaults; "" for other values."""
    value = getattr(value, "__func__", value)
    if not callable(value):
        return ""
    shown = []
    for p in inspect.signature(value).parameters.values():
        default = "" if p.default is p.empty else f"={p.default!r}"
        if dataclasses.is_dataclass(p.default):
            default = f"={type(p.default).__name__}(...)"
        star = "*" if p.kind is p.KEYWORD_ONLY and not any("*" in text for text in shown) else ""
        shown += [star] * bool(star) + [p.name + default]
    return f"({', '.join(shown)})"


def make_inputs() -> None:
    """Write MINE, a session with a crawl, and BENCH, a bench test: a joint follows a step."""
    run("calibrate new MINE --defaults --simulated")
    for bend, incline, belt in STATIONS:
        cells = f"lambda_deg={bend} incline_deg={incline} belt_speed_m_s={belt}"
        run(f"calibrate add MINE station {cells}")
    run(f"calibrate add MINE {CRAWL}")
    angle, rows = 0.0, []
    for k in range(200):
        goal = 60 * (20 <= k < 120)
        angle += min(max((goal - angle) / 4, -3.0), 3.0)  # 300 degrees a second at most
        rows.append(f"{k / 100},{goal},{angle:.1f}\n")
    Path("BENCH").write_text("t_s,setpoint_deg,angle_deg\n" + "".join(rows))


def sections() -> Iterator[tuple[str, Iterable[str]]]:
    """Yield each part: its heading and its lines."""
    yield "Commands", commands(cli)
    # A fit to the bench test that lists every parameter, however uncertain; few samples are quick.
    short = bench_fit.FitTuning(best_starts=2, moves=10, samples=64, max_sigma_ratio=1e9)
    with patch.object(bench_fit, "TUNING", short):
        for line in ANSWERS:
            yield f"JSON: {line}", keys_by_table(json.loads(run(f"{line} --json")))
    yield "Files: a scene", dict.fromkeys(scene_keys())
    yield "Files: a session", session_keys()
    yield "Files: fit.json", keys_by_table(json.loads(Path("MINE", "fit.json").read_text()))
    yield "Python", python_names()


def public() -> str:
    """Return the text of public.txt; the current folder must be empty, and gets files."""
    make_inputs()
    parts = (f"# {heading}\n" + "\n".join(lines) + "\n" for heading, lines in sections())
    return "\n".join(parts)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        PATH.write_text(public(), encoding="utf-8")
