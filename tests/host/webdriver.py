"""A real browser that stays open: headless Chromium, by Selenium."""

from __future__ import annotations

import os
import shutil
from importlib.resources import files
from pathlib import Path

import pytest
from robot.patience import LONG_S
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.wait import WebDriverWait

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
        chromium, driver = programs()
        options = webdriver.ChromeOptions()
        options.binary_location = chromium
        for flag in [*FLAGS, f"--window-size={width},{height}"]:
            options.add_argument(flag)
        self._window = webdriver.Chrome(options, webdriver.ChromeService(driver))
        metrics = {
            "width": width,
            "height": height,
            "deviceScaleFactor": 1,
            "mobile": width < 500 or paper,
        }
        self._devtools("Emulation.setDeviceMetricsOverride", metrics)
        features = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        if still:
            features.append({"name": "prefers-reduced-motion", "value": "reduce"})
        media = {"media": "print" if paper else "screen", "features": features}
        self._devtools("Emulation.setEmulatedMedia", media)

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        self._window.quit()

    def opens(self, url: str) -> None:
        self._window.get(url)

    def runs(self, script: str):
        """Return what a script's `return` gives."""
        return self._window.execute_script(script)

    def text(self, selector: str) -> str:
        return self.runs(f"return document.querySelector({selector!r}).textContent")

    def sees(self, selector: str, text: str) -> None:
        self._waits(lambda _: text in self.text(selector), f"{selector} never shows {text!r}")

    def waits_for(self, condition: str) -> None:
        self._waits(lambda _: self.runs(f"return {condition}"), f"never: {condition}")

    def clicks(self, selector: str) -> None:
        self._window.find_element(By.CSS_SELECTOR, selector).click()

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
        self._window.save_screenshot(path)

    def _waits(self, seen, never: str) -> None:
        WebDriverWait(self._window, LONG_S, 0.02).until(seen, never)

    def _devtools(self, command: str, parameters: dict) -> None:
        self._window.execute_cdp_cmd(command, parameters)
