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
from contextlib import contextmanager
from dataclasses import replace
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from command_line import answer
from robots import BINGHAM, OF_2005, gait_in_deg
from serpenoid.prediction.speed_samples import speed_band
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
const [core_js, tables_js, model_js] = process.argv.slice(2);
load(core_js), load(tables_js);
globalThis.model = require(model_js);
serpenoidCore().then((made) => {
  const core = new model.Core(made), given = JSON.parse(fs.readFileSync(0, 'utf8'));
  const answers = ((core, given) => { %s })(core, given);
  console.log(JSON.stringify(answers)), process.exit(0);
});
"""
STEADY = "return given.map((s) => core.steady(s));"
TORQUE = "return given.map((s) => model.peakTorque(core.motion(s, 480)).value);"
SERVO = "return given.map((s) => core.withServo(s, s.servo));"
LINK = "return given.map((hash) => model.fromHash(hash, model.PRESETS['2005']));"


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    if not shutil.which("em++"):
        pytest.skip("needs emscripten")
    folder = tmp_path_factory.mktemp("site") / "playground"
    subprocess.run([sys.executable, "docs/build_playground.py", folder], cwd=ROOT, check=True)
    (folder.parent / "index.html").write_text("<p>documentation")
    return folder / "index.html"


@pytest.fixture(scope="module")
def fitted(tmp_path_factory) -> Path:
    """A fitted session's folder; the repository holds no fits."""
    folder = tmp_path_factory.mktemp("sessions") / SESSION.name
    folder.mkdir()
    for name in ("session.toml", "readings.csv", "events.csv"):
        shutil.copy(SESSION / name, folder)
    sn.save_fit(sn.fit_friction(sn.load_session(folder)), folder)
    return folder


@contextmanager
def visiting(address: str, until: str = READY, still: bool = False) -> Iterator[Browser]:
    """Give a browser of its own at an address, once it is ready."""
    with Browser(1280, 1100, still=still) as visitor:
        visitor.opens(address)
        visitor.waits_for(until)
        yield visitor


@pytest.fixture(scope="module")
def browser(page) -> Iterator[Browser]:
    with visiting(page.as_uri()) as opened:
        opened.runs("$('digits').click(); change({servo: ''});")
        yield opened


def asked(script: str, given, folder: Path):
    """Return what a script says of the module and of what is given to it, in Node."""
    program, built = folder / "ask.js", ROOT / "build" / "web"
    program.write_text(NODE % script)
    called = ["node", program, built / "core.js", built / "tables.js", PARTS / "model.js"]
    done = subprocess.run(
        called, input=json.dumps(given), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


def states(count: int) -> list[dict[str, float]]:
    """Draw robots, grounds of all kinds, and gaits, bent ones too."""
    rng, drawn = np.random.default_rng(22), []
    for k in range(count):
        dry, viscous = k % 3 != 0, k % 3 != 1
        drawn.append(
            {
                "links": int(rng.integers(3, 10)),
                "mass": rng.uniform(0.03, 0.2),
                "length": rng.uniform(0.05, 0.12),
                "whole": k % 2,
                "ct": rng.uniform(0.02, 0.2) * viscous,
                "cn": rng.uniform(0.5, 5) * viscous,
                "ft0": rng.uniform(0.02, 0.2) * dry,
                "fn0": rng.uniform(0.3, 1.0) * dry,
                "alpha": rng.uniform(15, 75),
                "beta": rng.uniform(30, 120),
                "hz": rng.uniform(0.2, 1),
                "offset": rng.uniform(-10, 10) * (k % 5 == 0),
            }
        )
    return drawn


def parts(s: dict[str, float]) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    share = s["links"] if s["whole"] else 1
    robot = sn.Robot(int(s["links"]), s["mass"], s["length"])
    ground = sn.Ground(*(s[name] / share for name in ("ct", "cn", "ft0", "fn0")))
    angles = [math.radians(s[name]) for name in ("alpha", "beta", "offset")]
    return robot, ground, sn.Gait(angles[0], angles[1], 2 * math.pi * s["hz"], angles[2])


def test_thirty_gaits_equal_the_package(page, tmp_path) -> None:
    drawn = states(30)
    for s, found in zip(drawn, asked(STEADY, drawn, tmp_path), strict=True):
        robot, ground, gait = parts(s)
        wanted = sn.steady_gait(robot, ground, gait)
        assert found["speed"] == pytest.approx(wanted.speed_m_s, rel=1e-9), s
        assert found["power"] == pytest.approx(wanted.power_w, rel=1e-9), s
        # the last digits of a piece's length may decide how often it is halved for joint work
        claim = wanted.positive_power_error_w
        assert found["positivePower"] == pytest.approx(wanted.positive_power_w, abs=claim), s


def test_the_torque_is_that_of_a_run(page, tmp_path) -> None:
    drawn = states(6)
    for s, found in zip(drawn, asked(TORQUE, drawn, tmp_path), strict=True):
        robot, ground, gait = parts(s)
        scene = sn.Scene(
            robot,
            ground,
            gait,
            method="nonsmooth" if ground.dry else "dop853",
            start="steady",
            dt_s=gait.period_s / 480,
            duration_s=gait.period_s,
            record=("joints",),
            record_every=1,
        )
        wanted = np.abs(sn.simulate(scene).joint_torque_nm).max()
        assert found == pytest.approx(wanted, rel=1e-3), s


def test_servos_equal_the_package(page, tmp_path) -> None:
    """As far as settling goes: both stop at the same 2e-3 of the speed, by a secant method."""
    drawn = [s | {"servo": name} for s, name in zip(states(6), ("hobby", "SG90") * 3, strict=True)]
    for s, found in zip(drawn, asked(SERVO, drawn, tmp_path), strict=True):
        robot, ground, gait = parts(s)
        wanted = sn.steady_gait(robot, ground, gait, servo=sn.servo(s["servo"]).servo)
        assert found["speed"] == pytest.approx(wanted.speed_m_s, rel=5e-3), s
        assert found["amplitude"] == pytest.approx(wanted.amplitude_ratio, rel=5e-3), s


@pytest.mark.parametrize(
    "hash_text",
    [
        "",
        "#",
        "#&&==&%",
        "#alpha=1e999&beta=NaN&hz=-1&ct=",
        "#links=99&mass=0&inertia=-3",
        "#servo=%3Cscript%3E&alpha=",
        "#servo=constructor&alpha=0x10x",
    ],
)
def test_a_link_of_nonsense_leaves_what_was(page, tmp_path, hash_text: str) -> None:
    (found,) = asked(LINK, [hash_text], tmp_path)
    (wanted,) = asked(LINK, ["#alpha=70"], tmp_path)
    assert found == wanted


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
    browser.waits_for("state.alpha === 40")
    after = shown_speed(browser)
    assert after != before
    robot = OF_2005
    ground = BINGHAM
    gait = gait_in_deg(40, 75, math.pi)
    assert after == pytest.approx(sn.steady_gait(robot, ground, gait).speed_m_s, rel=1e-4)
    browser.waits_for("location.hash.includes('alpha=40')")
    assert "--alpha-deg 40" in browser.text("#command")


def test_the_shell_and_python_it_shows_give_its_number(browser, tmp_path) -> None:
    told = answer(browser.text("#command").removeprefix("serpenoid "))
    assert told["speed_m_s"] == pytest.approx(shown_speed(browser), rel=1e-4)
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


def test_the_map_is_complete_and_holds_the_packages_speeds(browser) -> None:
    # A busy page may still say that the map before its last change is done.
    browser.waits_for(f"{MAPPED} && map.values.every(Number.isFinite)")
    values = browser.runs("return [...map.values]")
    s = browser.runs("return state")
    for i, j in ((30, 12), (20, 20), (36, 30), (13, 31)):
        robot, ground, gait = parts(s | {"alpha": 105 / 40 * i, "beta": 4.5 * j})
        wanted = sn.steady_gait(robot, ground, gait, rtol=1e-3, powers=False).speed_m_s
        assert values[41 * i + j] == pytest.approx(wanted, rel=1e-9)


def test_a_fit_dropped_brings_its_friction_and_the_packages_band(browser, fitted) -> None:
    browser.runs("change({alpha: 70, beta: 75, hz: 0.5})")
    browser.runs(DROP % json.dumps((fitted / "fit.json").read_text()))
    browser.sees("#fit", "Friction and robot of nirakh-2005")
    browser.sees("#figures", "Speed that your fit allows")
    gait = gait_in_deg(70, 75, math.pi)
    fit = sn.load_fit(fitted)
    few = replace(fit.draws, rows=fit.draws.rows[8::16])  # those that the page takes
    of_few, of_fit = (speed_band(f, gait, servo=None) for f in (replace(fit, draws=few), fit))
    shown = browser.runs("return curve.band")
    assert shown == pytest.approx([of_few.low_m_s, of_few.high_m_s], rel=1e-5)
    # the package takes 64 others: ends of one posterior scatter by a third of its band
    assert shown == pytest.approx([of_fit.low_m_s, of_fit.high_m_s], abs=0.013)
    browser.runs("change({ct: 0.1})")
    assert browser.text("#fit") == ""  # it is another friction now
    browser.waits_for("curve && !curve.band")


BIG = {"links": 40, "link_mass_kg": 0.1, "link_length_m": 0.1, "link_inertia_kg_m2": 1e-4}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        *((text, "serpenoid fit") for text in ("no json", "{}", "[1]", "null", "9")),
        ('{"parameters": {}}', "serpenoid fit"),
        ({"robot": None}, "no fit"),
        ({"robot": BIG}, "links 40; the page takes 2 to 12"),
        ({"covariance": {"order": [], "values": []}}, "covariance is not complete"),
        ({"covariance": {"order": 3, "values": None}}, "no fit"),
    ],
)
def test_a_wrong_or_damaged_file_is_refused_in_words_and_changes_nothing(
    browser, fitted, given: str | dict, said: str
) -> None:
    before = browser.runs("return toHash(state)")
    if isinstance(given, dict):
        given = json.dumps(json.loads((fitted / "fit.json").read_text()) | given)
    browser.runs(DROP % json.dumps(given))
    browser.sees("#fit", said)
    assert browser.runs("return toHash(state)") == before


def test_no_friction_at_all_is_said(browser) -> None:
    kept = browser.runs("return toHash(state)")
    browser.runs("change({ct: 0, cn: 0, ft0: 0, fn0: 0})")
    assert "no friction" in browser.text("#problem")
    assert "no answer" in browser.text("#speed")
    browser.waits_for("location.hash.includes('ct=0&')")
    browser.runs(f"location.hash = {kept!r}")
    browser.waits_for("document.getElementById('problem').hidden")


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder on this machine; gives its address."""
    handler = functools.partial(SimpleHTTPRequestHandler, directory=str(folder))
    handler.log_message = lambda *_: None
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def test_folders_of_sessions_are_taken_or_refused_in_words(page, fitted, tmp_path) -> None:
    for name in ("session.toml", "readings.csv"):
        (tmp_path / "new").mkdir(exist_ok=True)
        shutil.copy(fitted / name, tmp_path / "new")
    (tmp_path / "empty").mkdir()
    with served(page.parents[1]) as site, visiting(f"{site}/playground/index.html") as visitor:
        for folder, said in (
            (tmp_path / "new", "This session has no fit yet. Run `serpenoid fit`"),
            (tmp_path / "empty", "Nothing that can be read"),
            (fitted / "readings.csv", "This session has no fit yet"),
            (PARTS / "page.html", "There is no fit.json in it"),
            (fitted, "Friction and robot of nirakh-2005"),
        ):
            visitor.drops(folder)
            visitor.sees("#fit", said)
        assert visitor.runs("return state.cn") == pytest.approx(1.2, rel=1e-5)


def test_the_keyboard_reaches_everything_and_moves_it(page) -> None:
    with visiting(page.as_uri()) as visitor:
        reached = []
        for _ in range(60):
            visitor.presses("Tab", 9)
            reached.append(
                visitor.runs("const e = document.activeElement; return e.id || e.tagName")
            )
            assert visitor.runs("""const e = document.activeElement;
                return e === document.body || e.matches(':focus-visible')"""), reached
            if reached[-1] == "r-alpha":
                visitor.presses("ArrowRight", 39)
                visitor.waits_for("state.alpha === 71")
            if reached[-1] == "map":
                visitor.presses("ArrowUp", 38)
                assert visitor.runs("return state.alpha") == 72
            if reached[-1] == "play":
                visitor.presses(" ", 32)
                assert visitor.text("#play") == "Play"
            if reached[-1] == "BODY":
                break
    expected = "home play preset n-alpha r-alpha n-ct servo file folder mode map command python"
    order = [reached.index(name) for name in expected.split()]
    assert order == sorted(order)  # as the page is read


def test_a_reader_who_wants_no_motion_gets_none_until_asked(page) -> None:
    with visiting(page.as_uri(), still=True) as visitor:
        assert visitor.text("#play") == "Play"
        visitor.runs(
            "requestAnimationFrame(() => requestAnimationFrame(() => { window.later = time; }))"
        )
        visitor.waits_for("window.later !== undefined")
        assert visitor.runs("return time") == 0
        visitor.clicks("#play")
        visitor.waits_for("time > 0")


@pytest.mark.parametrize("dark", [False, True])
def test_on_a_phone_from_a_server_with_a_link(page, dark: bool) -> None:
    link = "playground/index.html#alpha=33&beta=88&links=5&ct=bad&hz=99"
    with served(page.parents[1]) as address, Browser(390, 844, dark) as phone:
        phone.opens(f"{address}/{link}")
        phone.waits_for(READY)
        found = phone.runs("return [state.alpha, state.beta, state.links, state.hz]")
        assert found == [33, 88, 5, 0.5]
        assert phone.runs("return document.documentElement.scrollWidth") <= 390
        assert phone.barriers() == []
