"""The command line in this process: what it prints, and how it ends."""

from __future__ import annotations

import io
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


def serpenoid(*words: object, typed: str = "", check: bool = False) -> Done:
    """Run `serpenoid WORDS ...`; typed: its standard input. check: it must succeed."""
    out, err, status = io.StringIO(), io.StringIO(), 0
    argv = patch.object(sys, "argv", ["serpenoid", *map(str, words)])
    with (
        TemporaryFile("w+") as file,
        argv,
        patch.object(sys, "stdin", file if typed else sys.stdin),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        file.write(typed)
        file.seek(0)
        try:
            main()
        except SystemExit as left:
            status = int(left.code or 0)
    done = Done(status, out.getvalue(), err.getvalue())
    assert not (check and status), done.stdout + done.stderr
    return done
