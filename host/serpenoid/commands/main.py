"""The command line: degrees and plain words outside, SI and radians inside."""

from __future__ import annotations

import os
import signal
import sys
import threading
import warnings
from io import TextIOWrapper
from pathlib import Path
from types import FrameType

import click

from ..base import system
from ..base.errors import BadInput, SerpenoidError
from ..show.screen import say
from .boards import doctor, drive, flash, monitor, ports, trim
from .declare import command, directory, option
from .friction.calibrate import calibrate
from .friction.fitted import advise, compare, fit, report
from .friction.servo import servo
from .group import Commands, of_arguments, of_system
from .predict import optimize, steady, sweep
from .research import bench, figures
from .runs import examples, simulate, view
from .video import VIDEO_GROUP


@command()
@option(
    "--out",
    "folder",
    "Folder for sessions, figures and the report.",
    type=directory,
    default=Path("demo-out"),
)
def demo(folder: Path) -> None:
    """Go through the whole loop without a robot: session, friction, speed, floor, film, gait.

    The simulated robot has a hobby servo drawn at random, and no prediction is told which.
    """
    from .demo import run_demo

    run_demo(folder)


SECTIONS = {
    "See it work": (demo, examples, view),
    "Predict": (steady, sweep, optimize, simulate),
    "Measure friction": (calibrate, fit, advise, compare, report),
    "Measure a servo": (servo,),
    "Film the robot": (VIDEO_GROUP,),
    "Run the robot": (ports, flash, doctor, trim, drive, monitor),
    "For researchers": (bench, figures),
}


@click.group(
    cls=Commands,
    sections=SECTIONS,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="serpenoid")
def cli() -> None:
    """Predict, calibrate and drive a wheeled snake robot.

    Try `serpenoid demo` first: it needs no robot.
    """


class _Signalled(SystemExit):
    """SIGTERM or SIGHUP came; the code is 128 + its number."""


def _end(number: int, _frame: FrameType | None) -> None:
    raise _Signalled(128 + number)


def _run() -> object:
    """Run the command that was typed; a Ctrl-C that an import wraps into its error comes out."""
    try:
        return cli.main(standalone_mode=False)
    except (ImportError, RuntimeError) as error:
        if isinstance(error.__cause__, KeyboardInterrupt):
            raise error.__cause__ from None
        raise


def main() -> None:
    """Run the command line: exit 0 done, 1 the work failed, 2 bad arguments, 130 interrupted.

    SIGTERM and SIGHUP end it in order, so that no half-written file stays: exit 128 + signal.
    """
    for number in system.ENDING:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _end)
    warnings.showwarning = lambda message, *_: say(f"serpenoid: warning: {message}", err=True)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a terminal without degrees and minus signs gets `?`
            encoding = "utf-8" if system.WINDOWS else None
            stream.reconfigure(encoding=encoding, errors="replace")
    try:
        status = _run()
    except click.ClickException as error:
        say(f"serpenoid: {of_arguments(error)}", err=True)
        status = error.exit_code
    except (click.Abort, KeyboardInterrupt, _Signalled) as error:
        status = error.code if isinstance(error, _Signalled) else 130
        say("stopped", err=True)
        if threading.active_count() > 1:  # the core's loop cannot be ended, only left behind
            if sys.stdout:  # it may be closed
                sys.stdout.flush()
            os._exit(status if isinstance(status, int) else 1)
    except SerpenoidError as error:
        say(f"serpenoid: {error}", err=True)
        status = 2 if isinstance(error, BadInput) else 1
    except OSError as error:
        say(f"serpenoid: {of_system(error)}", err=True)
        status = 1
    except MemoryError:
        say("serpenoid: out of memory; run shorter, or record less often", err=True)
        status = 1
    sys.exit(status if isinstance(status, int) else 0)


if __name__ == "__main__":
    main()
