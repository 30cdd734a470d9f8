"""The command line, mostly in this process: what it prints, and how it ends."""

from __future__ import annotations

import io
import json
import shlex
import sys
from contextlib import redirect_stderr, redirect_stdout
from tempfile import TemporaryFile
from typing import NamedTuple
from unittest.mock import patch

from serpenoid.commands.main import main


class Done(NamedTuple):
    """What a command left."""

    returncode: int
    stdout: str
    stderr: str


def program(line: str) -> list[str]:
    """Return what starts `serpenoid LINE` in a process of its own."""
    return [sys.executable, "-m", "serpenoid", *shlex.split(line)]


def serpenoid(line: str, *words: object, typed: str = "", check: bool = False) -> Done:
    """Run `serpenoid LINE`, its words split as a shell does, and further words as they are.

    typed: its standard input. check: it must succeed.
    """
    output, err, status = io.StringIO(), io.StringIO(), 0
    argv = patch.object(sys, "argv", ["serpenoid", *shlex.split(line), *map(str, words)])
    with (
        TemporaryFile("w+") as file,
        argv,
        patch.object(sys, "stdin", file if typed else sys.stdin),
        redirect_stdout(output),
        redirect_stderr(err),
    ):
        file.write(typed)
        file.seek(0)
        try:
            main()
        except SystemExit as left:
            status = int(left.code or 0)
    done = Done(status, output.getvalue(), err.getvalue())
    assert not (check and status), done.stdout + done.stderr
    return done


def answer(line: str, *words: object) -> dict:
    """Return what `serpenoid LINE ... --json` answers."""
    return json.loads(serpenoid(line, *words, "--json", check=True).stdout)
