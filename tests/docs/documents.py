"""Commands and Python code that the pages show: in code blocks and in backticks."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
from serpenoid.commands.main import cli

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "CODE_OVERVIEW.md",
    ROOT / "firmware" / "README.md",
    ROOT / "calibration_data" / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
]
_FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)


def blocks(page: Path, kind: str) -> list[str]:
    """Return the fenced blocks of one kind."""
    return [body for name, body in _FENCE.findall(page.read_text()) if name == kind]


def typed(page: Path) -> Iterator[str]:
    """Yield the command lines `serpenoid ...` in a page's code blocks, without comments."""
    text = page.read_text()
    commands = [body.replace("\\\n", " ") for body in blocks(page, "console")]
    console = [line for body in commands for line in body.splitlines()]
    indented = re.findall(r"^ {4,}(serpenoid .*)$", _FENCE.sub("", text), re.M)
    for line in [*console, *indented]:
        bare = re.split(r"\s+#", line.strip())[0]
        if bare.startswith("serpenoid "):
            yield bare


def mentioned(text: str) -> list[str]:
    """Return the texts in backticks that begin with `serpenoid `."""
    return [" ".join(line.split()) for line in re.findall(r"`(serpenoid [a-z][^`]*)`", text)]


def unknown(line: str) -> str | None:
    """Return a message on a command or option that does not exist, or None."""
    command: click.Command = cli
    words = shlex.split(line.split("|", maxsplit=1)[0])[1:]
    while words and isinstance(command, click.Group):
        name = words.pop(0)
        if name.startswith("-") or not name.isalpha() or not name.islower():
            return None  # an option of the group, or a placeholder
        if name not in command.commands:
            return f"no command {name!r} in {line!r}"
        command = command.commands[name]
    options = {opt for p in command.params for opt in (*p.opts, *p.secondary_opts)}
    for word in words:
        option = word.split("=")[0]
        if option.startswith("--") and option not in {*options, "--help"}:
            return f"no option {option!r} in {line!r}"
    return None
