"""The playground: the core as WebAssembly equals the package; the page in a real browser."""

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
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from webdriver import Browser

pytestmark = pytest.mark.slow  # emscripten compiles the core in minutes
ROOT = Path(__file__).resolve().parents[2]
PARTS = ROOT / "docs" / "playground"
SESSION = ROOT / "calibration_data" / "nirakh-2005"
MOST_BYTES = 450_000  # over the wire, compressed
READY = "document.body.dataset.ready === 'yes'"
MAPPED = "document.body.dataset.map === 'done'"
# Puts a file with given text onto the page, as a hand would drop it.
DROP = """const t = new DataTransfer(); t.items.add(new File([%s], 'fit.json'));
dispatchEvent(new DragEvent('drop', {dataTransfer: t, cancelable: true}));"""
NODE = """const fs = require('fs'), vm = require('vm');
const load = (path) => vm.runInThisContext(fs.readFileSync(path, 'utf8'));
globalThis.require = require, globalThis.process = process;
globalThis.__dirname = '.', globalThis.__filename = 'x';
load(process.argv[2]);
const { Core, peakTorque, draws, readFit, fromHash, PRESETS } = require(process.argv[3]);
serpenoidCore().then((made) => {
  const core = new Core(made), states = JSON.parse(fs.readFileSync(0, 'utf8'));
  const torque = (s) => peakTorque(core.motion(s, 480)).value;
  const all = states.map((s) => ({ ...core.steady(s), torque: torque(s) }));
  console.log(JSON.stringify(all)), process.exit(0);
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
    with Browser(1280, 1100) as opened:
        opened.opens(page.as_uri())
        opened.waits_for(READY)
        yield opened


def states(count: int) -> list[dict[str, float]]:
    """Draw robots, grounds of all kinds, and gaits, bent ones too."""
    rng, drawn = np.random.default_rng(22), []
    for k in range(count):
        dry, viscous = k % 3 != 0, k % 3 != 1
        drawn.append({
            "links": int(rng.integers(3, 10)), "mass": rng.uniform(0.03, 0.2),
            "length": rng.uniform(0.05, 0.12), "whole": k % 2,
            "ct": rng.uniform(0.02, 0.2) * viscous, "cn": rng.uniform(0.5, 5) * viscous,
            "ft0": rng.uniform(0.02, 0.2) * dry, "fn0": rng.uniform(0.3, 1.0) * dry,
            "alpha": rng.uniform(15, 75), "beta": rng.uniform(30, 120), "hz": rng.uniform(0.2, 1),
            "offset": rng.uniform(-10, 10) * (k % 5 == 0),
        })  # fmt: skip
    return drawn


def parts(s: dict[str, float]) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    share = s["links"] if s["whole"] else 1
    robot = sn.Robot(int(s["links"]), s["mass"], s["length"])
    ground = sn.Ground(*(s[name] / share for name in ("ct", "cn", "ft0", "fn0")))
    angles = [math.radians(s[name]) for name in ("alpha", "beta", "offset")]
    return robot, ground, sn.Gait(angles[0], angles[1], 2 * math.pi * s["hz"], angles[2])


def test_thirty_gaits_equal_the_package(page, tmp_path) -> None:
    script, drawn = tmp_path / "ask.js", states(30)
    script.write_text(NODE)
    core = ROOT / "build" / "web" / "core.js"
    done = subprocess.run(["node", script, core, PARTS / "model.js"], input=json.dumps(drawn),
                          capture_output=True, text=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    for s, found in zip(drawn, json.loads(done.stdout), strict=True):
        robot, ground, gait = parts(s)
        wanted = sn.steady_gait(robot, ground, gait)
        assert found["speed"] == pytest.approx(wanted.speed_m_s, rel=1e-9), s
        assert found["power"] == pytest.approx(wanted.power_w, rel=1e-9), s
        assert found["positivePower"] == pytest.approx(wanted.positive_power_w, rel=1e-9), s


def test_the_torque_is_that_of_a_run(page, tmp_path) -> None:
    script, drawn = tmp_path / "ask.js", states(6)
    script.write_text(NODE)
    core = ROOT / "build" / "web" / "core.js"
    done = subprocess.run(["node", script, core, PARTS / "model.js"], input=json.dumps(drawn),
                          capture_output=True, text=True, check=True)  # fmt: skip
    for s, found in zip(drawn, json.loads(done.stdout), strict=True):
        robot, ground, gait = parts(s)
        scene = sn.Scene(robot, ground, gait, method="nonsmooth" if ground.dry else "dop853",
                         start="steady", dt_s=gait.period_s / 480, duration_s=gait.period_s,
                         record=("joints",), record_every=1)  # fmt: skip
        wanted = np.abs(sn.simulate(scene).joint_torque_nm).max()
        assert found["torque"] == pytest.approx(wanted, rel=1e-3), s


def test_the_page_is_small_and_asks_no_network(page) -> None:
    text = page.read_bytes()
    assert len(gzip.compress(text)) <= MOST_BYTES
    assert b"<script src" not in text
    assert b"<link" not in text


def shown_speed(browser: Browser) -> float:
    return float(browser.text("#speed").split()[0])


def test_a_slider_changes_the_answer_the_link_and_the_command(browser) -> None:
    before = shown_speed(browser)
    browser.runs(
        "const r = document.getElementById('r-alpha'); r.value = 40;"
        "r.dispatchEvent(new Event('input'));"
    )
    after = shown_speed(browser)
    assert after != before
    robot = sn.Robot(6, 0.0756, 0.076)
    ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    gait = sn.Gait(math.radians(40), math.radians(75), math.pi)
    assert after == pytest.approx(sn.steady_gait(robot, ground, gait).speed_m_s, rel=1e-4)
    assert "alpha=40" in browser.runs("return location.hash")
    assert "--alpha-deg 40" in browser.text("#command")


def test_the_shell_and_python_it_shows_give_its_number(browser, tmp_path) -> None:
    command = [*browser.text("#command").split()[1:], "--json"]
    called = subprocess.run(
        [sys.executable, "-m", "serpenoid", *command], capture_output=True, text=True, check=True
    )
    assert json.loads(called.stdout)["speed_m_s"] == pytest.approx(shown_speed(browser), rel=1e-4)
    script = tmp_path / "same.py"
    script.write_text(browser.text("#python"))
    printed = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert float(printed.stdout) == pytest.approx(shown_speed(browser), rel=1e-4)


def test_a_click_on_the_map_goes_there_and_arrows_move_on(browser) -> None:
    browser.waits_for(MAPPED)
    browser.runs("""const m = document.getElementById('map'), b = m.getBoundingClientRect();
const f = mapFrame(b.width, b.height), at = {clientX: b.left + f.X(90), clientY: b.top + f.Y(60)};
m.dispatchEvent(new MouseEvent('click', at));
m.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowUp'}));""")
    assert browser.runs("return [state.alpha, state.beta]") == pytest.approx([61, 90], abs=0.5)
    assert "Fastest" in browser.text("#map-says")


def test_a_fit_dropped_brings_its_friction_and_its_band(browser, tmp_path) -> None:
    fit = sn.save_fit(sn.fit_friction(sn.load_session(SESSION)), tmp_path / "fit.json")
    browser.runs(DROP % json.dumps(fit.read_text()))
    browser.sees("#fit", "Friction and robot of nirakh-2005")
    browser.sees("#figures", "Speed the fit allows")
    low, high = browser.runs("return curve.band")
    assert low < browser.runs("return answer.speed") < high


@pytest.mark.parametrize("text", ["no json", "{}", "[1]", "null", '{"parameters": {}}'])
def test_a_wrong_file_is_refused_in_words_and_changes_nothing(browser, text: str) -> None:
    before = browser.runs("return toHash(state)")
    browser.runs(DROP % json.dumps(text))
    browser.sees("#fit", "serpenoid fit")
    assert browser.runs("return toHash(state)") == before


def test_no_friction_at_all_is_said(browser) -> None:
    kept = browser.runs("return toHash(state)")
    browser.runs("change({ct: 0, cn: 0, ft0: 0, fn0: 0})")
    assert "no friction" in browser.text("#problem")
    assert "no answer" in browser.text("#speed")
    browser.runs(f"location.hash = {kept!r}")
    browser.waits_for("document.getElementById('problem').hidden")


@pytest.mark.parametrize("dark", [False, True])
def test_on_a_phone_from_a_server_with_a_link(page, dark: bool) -> None:
    handler = functools.partial(SimpleHTTPRequestHandler, directory=str(page.parents[1]))
    handler.log_message = lambda *_: None
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server, Browser(390, 844, dark) as phone:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        phone.opens(
            f"http://127.0.0.1:{server.server_port}/playground/index.html#alpha=33&beta=88&links=5&ct=bad&hz=99"
        )
        phone.waits_for(READY)
        assert phone.runs("return [state.alpha, state.beta, state.links, state.hz]") == [
            33,
            88,
            5,
            0.5,
        ]
        assert phone.runs("return document.documentElement.scrollWidth") <= 390
        nameless = phone.runs("""const all = 'input, select, button, canvas';
            return [...document.querySelectorAll(all)].filter((e) =>
            !(e.labels && e.labels.length) && !e.ariaLabel
            && !e.textContent.trim()
            && !e.getAttribute('aria-labelledby')).map((e) => e.id)""")
        assert nameless == []
        server.shutdown()
