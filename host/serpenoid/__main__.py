"""The command `serpenoid`, and `python -m serpenoid`: Ctrl-C ends even the importing quietly."""

from __future__ import annotations

# `signal` without its enums, whose import would take milliseconds in which a Ctrl-C still raises.
import _signal as signal  # type: ignore[import-not-found]
import os


def main() -> None:
    """Import the command line, and run it."""
    # Matrices here are small: threads of OpenBLAS would only wait for each other.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Meanwhile a Ctrl-C kills as it kills any program: there is nothing to leave in order yet.
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if usual:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from .commands.main import main as run

    if usual:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        run()
    finally:
        if usual:  # what Python does while it leaves cannot be interrupted without a traceback
            signal.signal(signal.SIGINT, signal.SIG_DFL)


if __name__ == "__main__":
    main()
