"""The window beside the dialogue: shown, closed, and not to be had; nobody ever waits for it."""

import importlib.util
import os
import select
import shutil
import struct
import subprocess
import threading
import time

import matplotlib.image
import numpy as np
import pytest
from calibration.test_page import session_in_progress
from robot.patience import LONG_S, until
from serpenoid.commands.friction.calibrate_person import _pictures
from serpenoid.show.session import window
from serpenoid.show.session.state import state_of
from serpenoid.show.session.window import Window, display_is_there

# A backend whose windows are files: DRAWN shows one, and CLOSED closes it as a click would.
BACKEND = """
import os, time
from matplotlib import pyplot
from matplotlib.backend_bases import FigureManagerBase, TimerBase
from matplotlib.backends.backend_agg import FigureCanvasAgg

TIMERS = []

class Timer(TimerBase):
    def _timer_start(self):
        TIMERS.append(self)

class FigureManager(FigureManagerBase):
    @classmethod
    def pyplot_show(cls, *, block=None):
        while pyplot.get_fignums() and not os.path.exists(os.environ["CLOSED"]):
            for timer in TIMERS:
                timer._on_timer()
            if pyplot.get_fignums():
                pyplot.savefig(os.environ["DRAWN"] + ".part", format="png")
                os.replace(os.environ["DRAWN"] + ".part", os.environ["DRAWN"])
            time.sleep(0.05)

class FigureCanvas(FigureCanvasAgg):
    manager_class = FigureManager
    required_interactive_framework = None

    def __init__(self, *args):
        super().__init__(*args)
        self.required_interactive_framework = "files"

    def new_timer(self, interval=None, callbacks=None):
        return Timer(interval, callbacks)
"""
BLUE = np.array([0x00, 0x72, 0xB2])


@pytest.fixture
def screen(tmp_path, monkeypatch):
    """Return the files of a made-up screen."""
    (tmp_path / "files_backend.py").write_text(BACKEND)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("MPLBACKEND", "module://files_backend")
    monkeypatch.setenv("DRAWN", str(tmp_path / "drawn.png"))
    monkeypatch.setenv("CLOSED", str(tmp_path / "closed"))
    return tmp_path


def state(steps):
    session, step = session_in_progress(steps)
    return state_of(session, step, frozenset(), "by hand")


def blue(path):
    """Return how many pixels have the colour of the straight robot's points."""
    if not path.exists():
        return 0
    pixels = np.round(255 * matplotlib.image.imread(path)[:, :, :3])
    return int((np.abs(pixels - BLUE).max(axis=2) < 3).sum())


def test_it_shows_the_newest_state_and_may_be_closed(screen):
    drawn = screen / "drawn.png"
    with Window() as shown:
        assert shown.show(state(5)) is False  # nobody waits for it
        assert until(lambda: shown.shows and blue(drawn))
        before = blue(drawn)
        assert shown.show(state(6))
        assert until(lambda: blue(drawn) > before)
        (screen / "closed").touch()
        assert until(lambda: not shown.shows)
        assert shown.show(state(7)) is False
        time.sleep(0.05)
        assert shown.show(state(7)) is False


def test_it_ends_with_the_dialogue_however_that_ends(screen):
    with Window() as shown:
        shown.show(state(5))
        assert until(lambda: shown.shows)
    assert shown._process.poll() is not None
    with Window() as orphan:
        assert until(lambda: orphan.shows)
        orphan._process.stdin.close()  # as when the dialogue is killed
        assert until(lambda: orphan._process.poll() == 0)


def test_a_window_that_hangs_holds_nobody_up(screen):
    with Window() as shown:
        assert until(lambda: shown.shows)
        os.kill(shown._process.pid, 19)  # SIGSTOP
        big = state(5) | {"say": "x" * 100_000}
        work = threading.Thread(target=lambda: [shown.show(big) for _ in range(20)], daemon=True)
        work.start()
        work.join(LONG_S)
        assert not work.is_alive()  # though nobody has read a byte
        shown._process.kill()


def test_without_windows_the_terminals_picture_stands_in(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")

    class Screen:
        said = ""

        def say(self, text):
            self.said += text + "\n"

    with Window() as shown:
        assert until(lambda: shown._process.poll() is not None)
        assert shown._process.poll() == window.NO_WINDOW
        console = Screen()
        told = _pictures(console, lambda session, step: shown.show(state(5)))
        for steps in (5, 6):
            told(*session_in_progress(steps))
    assert "deg of incline" in console.said
    console = Screen()
    told = _pictures(console, lambda session, step: True)
    for steps in (5, 6):
        told(*session_in_progress(steps))
    assert "deg of incline" not in console.said
    assert "no fit yet" in console.said


def test_a_display_is_asked_for_by_its_names(monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert not display_is_there()
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert display_is_there()


@pytest.mark.slow
def test_on_a_real_display(tmp_path, monkeypatch):
    if not shutil.which("Xvfb"):
        assert not os.environ.get("CI"), "CI needs Xvfb: make test-slow installs it"
        pytest.skip("needs Xvfb")
    if importlib.util.find_spec("_tkinter") is None:
        pytest.skip("needs a Python with tkinter")
    monkeypatch.delenv("MPLBACKEND", raising=False)
    ready, tell = os.pipe()
    command = ["Xvfb", "-displayfd", str(tell), "-screen", "0", "900x700x24", "-fbdir", tmp_path]
    server = subprocess.Popen(command, stderr=subprocess.DEVNULL, pass_fds=(tell,))
    try:
        assert select.select([ready], [], [], LONG_S)[0]
        monkeypatch.setenv("DISPLAY", f":{os.read(ready, 20).decode().strip()}")
        with Window() as shown:
            shown.show(state(12))
            assert until(lambda: shown.shows)
            assert until(lambda: _blue_on(tmp_path / "Xvfb_screen0") > 100)
    finally:
        server.terminate()
        server.wait()
        os.close(ready)
        os.close(tell)


def _blue_on(screen):
    """Return the blue pixels of a framebuffer in the format of xwd."""
    data = screen.read_bytes()
    head = struct.unpack(">25I", data[:100])
    begin, width, height = head[0] + 12 * head[19], head[12], head[5]
    pixels = np.frombuffer(data[begin : begin + width * height], np.uint8)
    rgb = pixels.reshape(height, width // 4, 4)[:, :, 2::-1].astype(int)
    return int((np.abs(rgb - BLUE).max(axis=2) < 3).sum())
