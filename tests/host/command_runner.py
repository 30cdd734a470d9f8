"""Commands run in the tests' own process."""

from __future__ import annotations

import inspect

from click.testing import CliRunner


def separate_runner() -> CliRunner:
    """Return a runner that keeps both streams apart; click below 8.2 mixes them unless told."""
    mixing = "mix_stderr" in inspect.signature(CliRunner).parameters
    return CliRunner(**({"mix_stderr": False} if mixing else {}))
