"""The playground: its WebAssembly core gives the speeds of the package; its page in a browser."""

from __future__ import annotations

import functools
import gzip
import json
import math
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from webdriver import Browser

pytestmark = pytest.mark.slow  # emscripten compiles the core in minutes
ROOT = Path(__file__).resolve().parents[2]
PARTS = ROOT / "docs" / "playground"
MAX_BYTES = 450_000  # size of the compressed page
CURVE_DRAWN = "document.body.dataset.curve === 'done'"
MAP_DRAWN = "document.body.dataset.map === 'done'"
NODE_PROGRAM = """const fs = require('fs'), vm = require('vm');
const load = (path) => vm.runInThisContext(fs.readFileSync(path, 'utf8'));
globalThis.require = require, globalThis.process = process, globalThis.onmessage = null;
globalThis.postMessage = () => {}, globalThis.__dirname = '.', globalThis.__filename = 'x';
const [built, parts] = process.argv.slice(2);
load(built + '/core.js'), load(built + '/tables.js');
load(parts + '/shared.js'), load(parts + '/worker.js');
serpenoidCore().then((module) => {
  const core = new Core(module), inputs = JSON.parse(fs.readFileSync(0, 'utf8'));
  const answers = inputs.map((s) => [core.ideal(s), core.typical(s), ...core.range(s)]);
  console.log(JSON.stringify(answers)), process.exit(0);
});
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    if not shutil.which("em++"):
        pytest.skip("needs emscripten")
    folder = tmp_path_factory.mktemp("site") / "playground"
    subprocess.run([sys.executable, "docs/build_playground.py", folder], cwd=ROOT, check=True)
    (folder.parent / "index.html").write_text("<p>documentation")
    return folder / "index.html"


@pytest.fixture(scope="module")
def browser(page) -> Iterator[Browser]:
    with Browser(1280, 1100) as window:
        window.opens(page.as_uri())
        window.waits_for(CURVE_DRAWN)
        yield window


def random_inputs(count: int) -> list[dict[str, float | str]]:
    """Return random robots, grounds of all kinds, gaits and servos."""
    rng, inputs = np.random.default_rng(22), []
    for k in range(count):
        dry, viscous = k % 3 != 0, k % 3 != 1
        links = int(rng.integers(3, 10))
        inputs.append(
            {
                "links": links,
                "mass": links * rng.uniform(0.03, 0.2),
                "length": rng.uniform(0.05, 0.12),
                "ct": links * rng.uniform(0.02, 0.2) * viscous,
                "cn": links * rng.uniform(0.5, 5) * viscous,
                "ft0": links * rng.uniform(0.02, 0.2) * dry,
                "fn0": links * rng.uniform(0.3, 1.0) * dry,
                "alpha": rng.uniform(15, 75),
                "beta": rng.uniform(30, 120),
                "hz": rng.uniform(0.2, 0.6),
                "servo": ("hobby", "MG996R")[k % 2],
            }
        )
    return inputs


def scene_parts(s: dict) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    robot = sn.Robot(s["links"], s["mass"] / s["links"], s["length"])
    frictions = {name: s[name] for name in ("ct", "cn", "ft0", "fn0")}
    ground = sn.Ground.whole_body(links=s["links"], **frictions)
    gait = sn.Gait(math.radians(s["alpha"]), math.radians(s["beta"]), 2 * math.pi * s["hz"])
    return robot, ground, gait


def test_speeds_equal_the_package(page, tmp_path) -> None:
    """Compare ideal joints to rounding, servos to 5e-3, and the range of servos to a rough step."""
    program, inputs, compared = tmp_path / "speeds.js", random_inputs(12), 0
    program.write_text(NODE_PROGRAM)
    command = ["node", program, ROOT / "build" / "web", PARTS]
    result = subprocess.run(
        command, input=json.dumps(inputs), capture_output=True, text=True, check=True
    )
    for s, (ideal, typical, low, high) in zip(inputs, json.loads(result.stdout), strict=True):
        robot, ground, gait = scene_parts(s)
        state = sn.steady_gait(robot, ground, gait, servo=sn.servo(s["servo"]))
        assert ideal == pytest.approx(state.ideal.speed_m_s, rel=1e-9), s
        assert typical == pytest.approx(state.speed_m_s, rel=5e-3, abs=1e-4), s
        if state.follows:
            compared += 1
            tolerance = (state.high_m_s - state.low_m_s) / 3 + 0.03 * typical
            assert [low, high] == pytest.approx([state.low_m_s, state.high_m_s], abs=tolerance), s
    assert compared >= 5


def test_the_page_is_small_and_needs_no_network(page) -> None:
    text = page.read_bytes()
    assert len(gzip.compress(text)) <= MAX_BYTES
    assert b"<script src" not in text
    assert b"<link" not in text


def test_a_slider_changes_the_answer_the_link_and_the_python(browser, tmp_path) -> None:
    first_speed = browser.text("#speed")
    browser.runs("""const slider = document.forms[0].elements.alpha;
slider.value = 60, slider.dispatchEvent(new Event('input', {bubbles: true}));""")
    browser.waits_for("shown.range")
    speed = browser.runs("return shown.speed")
    assert browser.text("#speed").startswith(f"{speed:.2g} m/s")
    assert browser.text("#speed") != first_speed
    assert "alpha=60" in browser.runs("return location.hash")
    script = tmp_path / "same.py"
    script.write_text(browser.text("#python"))
    printed = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert printed.stdout.startswith(f"About {speed:.2g} m/s ")


def test_messages_about_a_fast_gait_and_no_friction(browser) -> None:
    address_hash = browser.runs("return location.hash")
    for address, message in (("hz=2", "stay below"), ("ct=0&cn=0&ft0=0&fn0=0", "no friction")):
        browser.runs(f"location.hash = {'#' + address!r}")
        browser.sees("#speed", message)
        browser.runs(f"location.hash = {address_hash!r}")
        browser.waits_for("shown.range")


def test_speeds_of_the_map_and_a_click_on_it(browser) -> None:
    browser.runs("document.querySelector('#mapped').open = true")
    browser.waits_for(MAP_DRAWN)
    values, s = browser.runs("return [[...shown.map.values], state]")
    for i, j in ((25, 12), (20, 20), (31, 30), (13, 31)):
        robot, ground, gait = scene_parts(s | {"alpha": 3 * i, "beta": 4.5 * j})
        speed = sn.steady_gait(robot, ground, gait, rtol=1e-3, powers=False).speed_m_s
        assert values[41 * i + j] == pytest.approx(speed, rel=1e-9)
    browser.runs("""const map = document.getElementById('map'), box = map.getBoundingClientRect();
const {X, Y} = drawMap(map, shown.map, state);
map.dispatchEvent(new MouseEvent('click', {clientX: box.left + X(90), clientY: box.top + Y(60)}));
map.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowUp'}));""")
    assert browser.runs("return [state.alpha, state.beta]") == pytest.approx([61, 90], abs=1)


def test_reduced_motion_is_respected_until_play_is_pressed(page) -> None:
    with Browser(1280, 1100, still=True) as visitor:
        visitor.opens(page.as_uri())
        visitor.waits_for(CURVE_DRAWN)
        assert visitor.text("#play") == "Play"
        assert visitor.runs("return phase") == 0
        visitor.clicks("#play")
        visitor.waits_for("phase > 0")


@contextmanager
def local_server(folder: Path) -> Iterator[str]:
    """Serve a folder on this machine; yield its address."""
    handler = functools.partial(SimpleHTTPRequestHandler, directory=str(folder))
    handler.log_message = lambda *_: None
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [390, 1280])
def test_on_any_screen_from_a_server_with_a_link(page, width: int, dark: bool) -> None:
    """Ignore values of the link that are outside their limits, and unknown names."""
    link = "playground/index.html#alpha=33&beta=88&links=5&ct=bad&cn=-1&servo=%3Cb%3E&constructor=1"
    with local_server(page.parents[1]) as address, Browser(width, 844, dark) as visitor:
        visitor.opens(f"{address}/{link}")
        visitor.waits_for(CURVE_DRAWN)
        values = visitor.runs(
            "const s = state; return [s.alpha, s.beta, s.links, s.ct, s.cn, s.servo]"
        )
        assert values == [33, 88, 5, 0.084, 1.2, "hobby"]
        visitor.runs(
            "document.querySelectorAll('details').forEach((item) => { item.open = true; })"
        )
        visitor.waits_for(MAP_DRAWN)
        assert visitor.runs("return document.documentElement.scrollWidth") <= width
        assert visitor.barriers() == []
