"""A window with a session's points and lines, in a process of its own.

The dialogue only leaves its newest state: a window that is closed, stuck or cannot be opened
disturbs nobody, and the terminal's picture stands in for it.
"""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from types import TracebackType
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

State = Mapping[str, Any]
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#8a5a9e", "#a37b00")
LOOK_MS = 200  # how often the window looks for a new state
NO_WINDOW = 3  # exit status: matplotlib has no windows here
END_S = 2.0


def display_is_there() -> bool:
    """Return whether a window may be tried: matplotlib itself finds out whether it has one."""
    return sys.platform == "darwin" or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    )


class Window:
    """Show states while `with Window() as window:` lasts; no call waits for the window."""

    def __enter__(self) -> Window:
        self._newest: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._up = threading.Event()
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for the dialogue
        )
        for work in (self._write, self._listen):
            threading.Thread(target=work, daemon=True).start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.terminate()
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._newest.put(None)

    @property
    def shows(self) -> bool:
        """Return whether there is a window now: open, and not closed again."""
        return self._up.is_set() and self._process.poll() is None

    def show(self, state: State) -> bool:
        """Leave a state to be shown; return whether there is a window that will."""
        self._newest.put(json.dumps(state, allow_nan=False).encode() + b"\n")
        return self.shows

    def _write(self) -> None:
        """Pass the newest state on, however long the window takes to read it."""
        pipe = self._process.stdin
        assert pipe is not None  # asked for
        with suppress(OSError, ValueError):
            while (line := self._newest.get()) is not None:
                while not self._newest.empty() and line is not None:
                    line = self._newest.get()
                if line is None:
                    break
                pipe.write(line)
                pipe.flush()

    def _listen(self) -> None:
        pipe = self._process.stdout
        assert pipe is not None  # asked for
        with suppress(OSError, ValueError):
            if pipe.readline():
                self._up.set()


def draw(figure: Figure, ax: Axes, state: State) -> None:
    """Draw points, lines and bands of every bend, and the running fit."""
    ax.clear()
    for bend, colour in zip(state["bends"], COLOURS * 3, strict=False):
        points, line = bend["points"], bend["line"]
        if points:
            ax.plot(*zip(*points, strict=True), "o", color=colour, label=bend["name"])
        if line:
            x, y, half = zip(*line, strict=True)
            ax.plot(x, y, color=colour)
            low, high = ([v + k * h for v, h in zip(y, half, strict=True)] for k in (-1, 1))
            ax.fill_between(x, low, high, color=colour, alpha=0.16, lw=0)
    ax.set(xlabel="inclinometer (deg)", ylabel="belt past the robot (m/s)")
    ax.set_title(f"{state['name']}: {' '.join(state['aim'].split())}")
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="upper left")
        ax.set_ylim(bottom=0.0)
    fit = "\n".join(
        f"{r['name']} {r['value']:.3g} ({r['low']:.3g} to {r['high']:.3g}) {r['unit']}"
        for r in state["fit"]
    )
    ax.text(
        0.99,
        0.02,
        fit or "too few readings for a fit yet",
        transform=ax.transAxes,
        ha="right",
        va="bottom",
        fontsize=9,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none"},
    )
    figure.canvas.draw_idle()


def main() -> int:
    """Show states from standard input until it ends or the window is closed."""
    import matplotlib as mpl
    import matplotlib.pyplot as plt

    from ..plot import STYLE

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with mpl.rc_context(cast(Any, STYLE | {"figure.raise_window": False})):
        made, ax = plt.subplots(figsize=(7.0, 5.0), num="serpenoid: calibration")
        if getattr(made.canvas, "required_interactive_framework", None) is None:
            return NO_WINDOW
        states: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        threading.Thread(target=_read, args=(states,), daemon=True).start()
        timer = made.canvas.new_timer(interval=LOOK_MS)
        timer.add_callback(_look, states, made, ax)
        timer.start()
        told: list[int] = []
        made.canvas.mpl_connect("draw_event", lambda _: told or told.append(_say_up()))
        plt.show()
    return 0


def _read(states: queue.SimpleQueue[str | None]) -> None:
    for line in sys.stdin:
        states.put(line)
    states.put(None)


def _look(states: queue.SimpleQueue[str | None], made: Figure, ax: Axes) -> None:
    """Draw the newest state, if there is one; close where there will be none any more."""
    import matplotlib.pyplot as plt

    newest: str | None = ""
    while not states.empty():
        newest = states.get()
        if newest is None:
            return plt.close(made)
    return draw(made, ax, json.loads(newest)) if newest else None


def _say_up() -> int:
    return os.write(sys.stdout.fileno(), b"up\n")


if __name__ == "__main__":
    sys.exit(main())
