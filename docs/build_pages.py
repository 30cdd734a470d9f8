"""Write the reference pages from the program: commands, JSON, errors, API, moving robots."""

from __future__ import annotations

import inspect
import json
import shlex
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import chdir
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import build_playground
import click
import serpenoid as sn
import tomllib
from click.testing import CliRunner
from serpenoid.base import errors
from serpenoid.commands.main import cli
from serpenoid.robot import RobotBoard
from serpenoid.robot.wire.protocol import ERRORS

DOCS = Path(__file__).resolve().parent
GENERATED = DOCS / "generated"
LIMPING = DOCS.parent / "host" / "examples" / "limping_on_a_slope.toml"
GAIT = "--alpha-deg 70 --beta-deg 75 --omega-rad-s 5"
EXAMPLE_LENGTH = 60  # characters of a value in a table of keys
MEANINGS = tomllib.loads((DOCS / "json_keys.toml").read_text(encoding="utf-8"))
SESSION = DOCS.parent / "calibration_data" / "nirakh-2005"
ANSWERS = {  # commands whose --json is shown key by key
    "steady": f"steady {GAIT}",
    "steady --formulation implicit": f"steady {GAIT} --formulation implicit",
    "sweep": "sweep --alpha-deg 60:70:10 --beta-deg 75 --omega-rad-s 5",
    "optimize": "optimize --robot paper --speed-m-s 0.1",
    "simulate": f"simulate --scene '{LIMPING}' --duration-s 0.5",
    "fit": f"fit '{SESSION}'",
    "compare": f"compare '{SESSION}' --gait 70 75 0.5 --set samples=16",
    "advise": f"advise '{SESSION}' --gait 70 75 0.5 --set samples=16",
    "drive": f"drive --port virtual:fast {GAIT} --duration-s 1",
    "doctor": "doctor --port virtual:fast --listen-s 1",
}


def invoke(arguments: list[str]) -> str:
    """Return the output of a command; raise SystemExit if it fails."""
    done = CliRunner().invoke(cli, arguments, catch_exceptions=False)
    if done.exit_code:
        raise SystemExit(f"serpenoid {' '.join(arguments)}: {done.output}")
    return done.stdout


def commands(group: click.Group, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield every command below a group, as the words that call it."""
    for name, command in sorted(group.commands.items()):
        yield (*path, name)
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))


def command_page() -> str:
    """Return the help of every command, and the names that its --set takes."""
    parts = ["# Commands\n\nAs `--help` and `--set help` print them.\n"]
    for words in commands(cli):
        text = invoke([*words, "--help"]).replace("Usage: cli", "Usage: serpenoid")
        if "--set NAME=VALUE" in text:
            text += f"\nNames of --set:\n{invoke([*words, '--set', 'help'])}"
        parts.append(f"## serpenoid {' '.join(words)}\n\n```text\n{text.rstrip()}\n```\n")
    return "\n".join(parts)


def keys(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield every key in an answer with an example of its value; of a list, the first item's."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from keys(inner, f"{path}.{name}" if path else name)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        yield from keys(value[0], f"{path}[]")
    else:
        text = json.dumps(value, ensure_ascii=False)
        yield path, text if len(text) < EXAMPLE_LENGTH else f"{text[: EXAMPLE_LENGTH - 4]} …"


JSON_HEAD = """# JSON keys

`--json` prints strict JSON: what is not finite is `null`. A key's ending is its unit: `_m_s` m/s,
`_rad` radians, `_w` watts. The values are those of the command at this build.
"""
API_HEAD = """# Python

`import serpenoid as sn`. SI units and radians; links and joints count from the tail.
`print(result)` shows a table. `plot("figure.png")` of a `Run`, `Sweep`, `Steady`, `FrictionFit` or
`Comparison` returns a matplotlib figure.
"""


def table(columns: list[str], rows: list[list[Any]]) -> str:
    """Return a table of MyST."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(str(cell) for cell in line)} |" for line in lines) + "\n"


def meaning(key: str) -> str:
    """Return the meaning of a key; raise SystemExit if docs/json_keys.toml has none."""
    for pattern, words in MEANINGS.items():
        if fnmatchcase(key, pattern.replace("[]", "[[][]]")):
            return words
    raise SystemExit(f"docs/json_keys.toml says nothing of {key!r}")


def json_page() -> str:
    """Return the keys of every answer with their meaning and their value in this build."""
    parts = [JSON_HEAD]
    for name, line in ANSWERS.items():
        arguments = shlex.split(line)
        answer = json.loads(invoke([*arguments, "--json"]))
        rows = [[f"`{key}`", meaning(key), f"`{shown}`"] for key, shown in keys(answer)]
        typed = " ".join(Path(a).name if "/" in a else a for a in arguments)
        parts.append(f"## `{name}`\n\n```text\nserpenoid {typed} --json\n```\n")
        parts.append(table(["key", "meaning", "for example"], rows).replace(str(DOCS.parent), ""))
    return "\n".join(parts)


def when_and_cure(kind: type) -> tuple[str, str]:
    """Return when an exception is raised and the way out, from its docstring."""
    parts = [" ".join(part.split()) for part in (inspect.getdoc(kind) or "").split("\n\n")]
    cures = [part.removeprefix("Way out: ") for part in parts if part.startswith("Way out: ")]
    return parts[0], cures[0] if cures else ""


def error_page() -> str:
    """Return the exceptions, and the errors of a board."""
    kinds = [
        [f"`{name}`", *when_and_cure(kind)]
        for name, kind in vars(errors).items()
        if inspect.isclass(kind) and issubclass(kind, sn.SerpenoidError)
    ]
    rows = [[number, f"`{word}`", *texts] for word, (number, *texts) in ERRORS.items()]
    return (
        f"## Exceptions\n\n{table(['exception', 'when', 'way out'], kinds)}\n"
        "## What a board refuses\n\n"
        + table(["number", "word", "what happened", "what to do"], sorted(rows))
    )


def api_pages() -> dict[str, str]:
    """Return a page for each public name, and "api", which lists them."""
    groups = {"Functions": {}, "Classes": {}, "Exceptions": {}}
    for name in sn.__all__:
        value = getattr(sn, name)
        kind = "Functions" if inspect.isfunction(value) else "Classes"
        if inspect.isclass(value) and issubclass(value, Exception):
            kind = "Exceptions"
        groups[kind][f"serpenoid.{name}"] = value
    groups["The robot"] = {"serpenoid.robot.RobotBoard": RobotBoard}
    pages, parts = {}, [API_HEAD]
    for title, names in groups.items():
        kind = "autofunction" if title == "Functions" else "autoclass"
        options = "" if title in ("Functions", "Exceptions") else "   :members:\n"
        lines = []
        for name, value in names.items():
            shown = f"```{{eval-rst}}\n.. {kind}:: {name}\n{options}```\n"
            pages[name] = f"# `{name}`\n\n{shown}"
            first = str(inspect.getdoc(value)).split("\n\n")[0].replace("\n", " ")
            lines.append(f"- [`{name.split('.')[-1]}`]({name}.md): {first}")
        toctree = ["```{toctree}", ":hidden:", "", *names, "```\n"]
        parts.append("\n".join([f"## {title}\n", *lines, "", *toctree]))
    return pages | {"api": "\n".join(parts)}


def pages(folder: Path) -> None:
    """Write two pages that show moving robots."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch, chdir(scratch):
        drive = f"drive --port virtual:fast {GAIT} --duration-s 8 --record run.wire"
        invoke(drive.split())
        invoke(["view", "run.wire", "--out", str(folder / "virtual.html")])
        invoke(["view", str(LIMPING), "--out", str(folder / "limping.html")])


PLAYGROUND = """<iframe class="view" src="playground/index.html" title="the playground"></iframe>

Move a slider: the core solves the gait in your browser, with nothing to install.
<a href="playground/index.html">The playground on a page of its own</a> keeps your setting in
its address.
"""
NO_PLAYGROUND = """<iframe class="view" src="_static/virtual.html" title="a robot"></iframe>

This build has no playground: it needs emscripten. The snake is the virtual robot
of `serpenoid drive --port virtual`.
"""


def main() -> None:
    """Write all generated pages."""
    shutil.rmtree(GENERATED, ignore_errors=True)
    pages(GENERATED / "static")
    has_playground = build_playground.build(GENERATED / "pages" / "playground")
    front = PLAYGROUND if has_playground else NO_PLAYGROUND
    (GENERATED / "front.md").write_text(front, encoding="utf-8")
    for name, text in (
        ("commands", command_page()),
        ("json_keys", json_page()),
        ("errors", error_page()),
        *api_pages().items(),
    ):
        (GENERATED / f"{name}.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
