"""A real browser that stays open: headless Chromium through chromedriver, spoken to over HTTP."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import subprocess
import time
import urllib.error
import urllib.request
from contextlib import suppress
from importlib.resources import files
from pathlib import Path

import pytest
from robot.patience import LONG_S

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # W3C WebDriver, section 11
FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]


def programs() -> tuple[str, str]:
    found = shutil.which("chromium") or shutil.which("google-chrome"), shutil.which("chromedriver")
    if all(found):
        return found
    if os.environ.get("CI"):
        pytest.fail("CI needs chromium and chromium-driver: make test installs them")
    return pytest.skip("needs chromium and chromium-driver")


class Browser:
    """One window; `with Browser() as browser:`."""

    def __init__(
        self,
        width: int = 1100,
        height: int = 900,
        dark: bool = False,
        paper: bool = False,
        still: bool = False,
    ):
        self._chromium, self._driver = programs()
        self._size = width, height
        self._dark, self._paper, self._still = dark, paper, still

    def __enter__(self) -> Browser:
        port = next(filter(None, (self._start() for _ in range(5))), None)
        assert port, "chromedriver does not start"
        self._base = f"http://127.0.0.1:{port}/session"
        flags = [*FLAGS, "--window-size={},{}".format(*self._size)]
        if self._dark:
            flags.append("--force-dark-mode")
        options = {"binary": self._chromium, "args": flags}
        wanted = {"capabilities": {"alwaysMatch": {"goog:chromeOptions": options}}}
        self._base += "/" + self._begin(wanted)
        metrics = {
            "width": self._size[0],
            "height": self._size[1],
            "deviceScaleFactor": 1,
            "mobile": self._size[0] < 500 or self._paper,
        }
        self._devtools("Emulation.setDeviceMetricsOverride", metrics)
        features = [{"name": "prefers-color-scheme", "value": "dark" if self._dark else "light"}]
        if self._still:
            features.append({"name": "prefers-reduced-motion", "value": "reduce"})
        media = {"media": "print" if self._paper else "screen", "features": features}
        self._devtools("Emulation.setEmulatedMedia", media)
        return self

    def _start(self) -> int | None:
        """Start chromedriver; return its port, None where it ended: another took its port."""
        self._process = subprocess.Popen(
            [self._driver, "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        for line in self._process.stdout:
            if found := re.search(r"started successfully on port (\d+)", line):
                return int(found[1])
        self._process.wait(LONG_S)
        self._process.stdout.close()
        return None

    def __exit__(self, *_: object) -> None:
        try:
            self._ask("", method="DELETE")
        finally:
            self._process.terminate()
            self._process.wait(LONG_S)
            self._process.stdout.close()

    def _begin(self, wanted: dict) -> str:
        """Return a session's name; a busy machine may be too slow for chromedriver at first."""
        for _ in range(2):
            with suppress(urllib.error.HTTPError):
                return self._ask("", wanted)["sessionId"]
        return self._ask("", wanted)["sessionId"]

    def opens(self, url: str) -> None:
        self._ask("/url", {"url": url})

    def runs(self, script: str):
        """Return what a script's `return` gives."""
        return self._ask("/execute/sync", {"script": script, "args": []})

    def text(self, selector: str) -> str:
        return self.runs(f"return document.querySelector({selector!r}).textContent")

    def sees(self, selector: str, text: str) -> None:
        end = time.monotonic() + LONG_S
        while text not in (found := self.text(selector)):
            assert time.monotonic() < end, f"{selector} shows {found!r}, not {text!r}"
            time.sleep(0.02)

    def waits_for(self, condition: str) -> None:
        end = time.monotonic() + LONG_S
        while not self.runs(f"return {condition}"):
            assert time.monotonic() < end, f"never: {condition}"
            time.sleep(0.02)

    def clicks(self, selector: str) -> None:
        found = self._ask("/element", {"using": "css selector", "value": selector})
        self._ask(f"/element/{found[ELEMENT]}/click", {})

    def presses(self, key: str, code: int) -> None:
        """Press and release one key, by its name and its virtual key code."""
        text = {"text": " "} if key == " " else {}
        for kind in ("keyDown" if text else "rawKeyDown", "keyUp"):
            event = {"type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code}
            self._devtools("Input.dispatchKeyEvent", event | (text if kind == "keyDown" else {}))

    def drops(self, path: Path) -> None:
        """Drag a file or a folder of this machine onto the page."""
        data = {"items": [], "files": [str(path)], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            event = {"type": kind, "x": 200, "y": 200, "data": data}
            self._devtools("Input.dispatchDragEvent", event)

    def barriers(self) -> list[str]:
        """Return what axe-core holds against the page, and where."""
        axe = files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
        self.runs(f"{axe}\nwindow.axed = null; axe.run().then((found) => {{ axed = found; }});")
        self.waits_for("window.axed")
        assert self.runs("return axed.passes.length") > 5  # it has looked
        return self.runs(
            "return axed.violations.flatMap((v) => v.nodes.map((n) => `${v.id}: ${n.target}`))"
        )

    def picture(self, path: Path) -> None:
        path.write_bytes(base64.b64decode(self._ask("/screenshot")))

    def _devtools(self, command: str, parameters: dict) -> None:
        self._ask("/goog/cdp/execute", {"cmd": command, "params": parameters})

    def _ask(self, path: str, body: dict | None = None, method: str | None = None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self._base + path, data, method=method)
        with urllib.request.urlopen(request, timeout=5 * LONG_S) as answer:
            return json.loads(answer.read())["value"]
