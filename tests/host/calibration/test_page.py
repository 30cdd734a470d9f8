"""The page beside the treadmill: whom it answers, and what a real browser shows of it."""

import http.client
import json
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from importlib.resources import files
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from robot.fake_board import FakeBoard, honest
from robot.patience import LONG_S, until
from robots import gait_in_deg
from serpenoid import Ground
from serpenoid.calibration.taking.journal import Journal
from serpenoid.calibration.taking.new_session import create_session, default_setup
from serpenoid.calibration.taking.person.session_robot import SessionRobot
from serpenoid.calibration.taking.procedure import next_step
from serpenoid.calibration.taking.simulated import SimulatedPerson, Truth
from serpenoid.calibration.taking.treadmill import Posture, take_step
from serpenoid.commands.friction import calibrate_person
from serpenoid.commands.friction.calibrate_person import steering
from serpenoid.model.errors import RobotLost
from serpenoid.robot.wire import dialogue
from serpenoid.show.pages.server import MOST_STREAMS, Page
from serpenoid.show.session.state import state_of
from simulated_sessions import MemoryRecord
from webdriver import Browser

HTML = files("serpenoid.show.session").joinpath("beside.html").read_text(encoding="utf-8")


def ask(page, method="GET", path=None, **headers):
    """Return status and body of one request."""
    connection = http.client.HTTPConnection("127.0.0.1", page.port, timeout=LONG_S)
    path = f"/{page.token}/" if path is None else path
    headers.setdefault("Host", f"127.0.0.1:{page.port}")
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    body = answer.read().decode()
    connection.close()
    return answer.status, body


def session_in_progress(steps=12):
    setup = default_setup("made up")
    setup = replace(setup, procedure=replace(setup.procedure, gaits=()))
    record = MemoryRecord(setup)
    treadmill = SimulatedPerson(setup, Truth(Ground(0.084, 1.2, 0.14, 0.27)), seed=2)
    posture = Posture()
    for _ in range(steps):
        take_step(record, treadmill, posture)
    return record.session, next_step(record.session, posed_deg=posture.bend_deg)


def test_the_state_holds_what_is_to_be_done_and_what_was_found():
    session, step = session_in_progress(30)
    state = state_of(session, step, "by hand")
    json.dumps(state, allow_nan=False)
    assert state["last"].startswith(f"{session.numbered[-1].number}: ")
    assert len(state["fit"]) == 4
    picture = ElementTree.fromstring(f"<svg>{state['picture']}</svg>")
    assert len(picture.findall("circle")) == len(session.kept)
    # The line's band is narrowest near the middle of its points.
    band = np.reshape(picture.find("polygon").get("points").split(), (2, -1, 2)).astype(float)
    widths = (band[1, ::-1] - band[0])[:, 1]
    assert widths.argmin() not in (0, len(widths) - 1)


def test_only_the_token_the_own_host_and_the_own_origin_are_answered():
    stops = []
    with Page(HTML, lambda: stops.append(1), buttons={"left": lambda: "+0.25 deg"}) as page:
        own = f"http://127.0.0.1:{page.port}"
        assert ask(page)[0] == 200
        assert ask(page, path="/")[0] == 404
        assert ask(page, path="/wrong/")[0] == 404
        assert ask(page, path=f"/{page.token}/../etc")[0] == 404
        assert ask(page, Host="evil.example")[0] == 404
        stop = f"/{page.token}/stop"
        assert ask(page, "GET", stop)[0] == 404
        assert ask(page, "POST", stop)[0] == 404
        assert ask(page, "POST", stop, Origin="http://evil.example")[0] == 404
        assert ask(page, "POST", "/wrong/stop", Origin=own)[0] == 404
        assert ask(page, "POST", f"/{page.token}/right", Origin=own)[0] == 404
        left = f"/{page.token}/left"
        assert ask(page, "GET", left, Origin=own)[0] == ask(page, "POST", left)[0] == 404
        assert ask(page, "POST", left, Origin=own) == (200, '{"shown": "+0.25 deg"}')
        assert not stops
        assert ask(page, "POST", stop, Origin=own) == (200, '{"stopped": true}')
        assert stops == [1]


def test_keys_that_two_pages_press_at_once_all_count():
    robot = SteeredRobot()
    keys = steering(robot)
    with ThreadPoolExecutor() as pages:
        list(pages.map(lambda key: keys[key](), ["left", "left", "right"] * 10))
    assert robot.steps == 10


class SteeredRobot:
    steps = 0

    def steer(self, steps):
        wanted = self.steps + steps
        time.sleep(0.001)  # until the board has answered
        self.steps = wanted
        return f"{self.steps} step"


def test_a_key_at_the_terminal_is_shown_before_the_next_step(tmp_path, monkeypatch):
    """The page is told the offset with all else that it shows."""
    folder = create_session(tmp_path / "session", default_setup("steered"))
    with ExitStack() as stack, SessionRobot("virtual:fast") as robot:
        journal = stack.enter_context(Journal(folder))
        console = SimpleNamespace(say=lambda text: None)
        told, keys = calibrate_person._page(stack, journal, robot, False, console)
        sent = []
        monkeypatch.setattr(Page, "publish", lambda self, state: sent.append(state))
        robot.pose(0.0)
        told(journal.session, next_step(journal.session))
        keys["left"]()
    assert sent[0]["offset"].startswith("+0.00")
    assert sent[1] == sent[0] | {"offset": "+0.25 deg on every joint"}


def test_a_stop_that_fails_says_so():
    def lost():
        raise RobotLost("unplugged")

    with Page(HTML, lost) as page:
        status, said = ask(
            page, "POST", f"/{page.token}/stop", Origin=f"http://127.0.0.1:{page.port}"
        )
        assert (status, json.loads(said)["error"]) == (500, "unplugged")


def test_it_is_bound_to_this_machine_unless_told():
    with Page(HTML) as page:
        assert page._server.server_address[0] == "127.0.0.1"
    with Page(HTML, lan=True) as page:
        assert page._server.server_address[0] in ("0.0.0.0", "::")
        assert ask(page)[0] == 200
        assert ask(page, Host="evil.example")[0] == 404


def test_streams_are_limited_and_end_with_the_page():
    with Page(HTML) as page:
        held = [page.streams.acquire(blocking=False) for _ in range(MOST_STREAMS)]
        assert all(held)
        assert ask(page, path=f"/{page.token}/states")[0] == 503
    got = []
    page = Page(HTML)
    with page:
        page.publish({"a": 1})
        thread = threading.Thread(
            target=lambda: got.append(ask(page, path=f"/{page.token}/states"))
        )
        thread.start()
        assert until(lambda: page.streams._value < MOST_STREAMS)
    thread.join()
    assert 'data: {"a": 1}' in got[0][1]


GAIT = gait_in_deg(30, 75, 2.0)
WITHIN_MS = 200  # a stop's way from the page to the board's word that it holds


def press_stop(page):
    return ask(page, "POST", f"/{page.token}/stop", Origin=f"http://127.0.0.1:{page.port}")


def test_stop_overtakes_a_question_that_is_not_answered(monkeypatch):
    """The robot holds while the dialogue's thread still waits for another verdict."""
    monkeypatch.setattr(dialogue, "PATIENCE_S", LONG_S)
    with FakeBoard() as fake, SessionRobot(fake.port) as seat, Page(HTML, seat.halt) as page:
        seat.go(GAIT)
        assert fake.state == "gait"
        fake.to_host = lambda line: b"" if line.startswith(b"ok: #") else line
        talk = threading.Thread(target=seat.tick)
        talk.start()
        assert until(lambda: b" status *" in fake.received)
        told = []
        stop = threading.Thread(target=lambda: told.append(press_stop(page)))
        stop.start()
        assert fake.await_state("hold")
        assert talk.is_alive()
        assert seat.stopped
        fake.to_host = honest
        for thread in (talk, stop):
            thread.join()
        assert told == [(200, '{"stopped": true}')]
        seat.go(GAIT)
        assert seat._robot.status().state == "hold"  # until it is released
        seat.release()
        seat.go(GAIT)
        assert seat._robot.status().state == "gait"


def in_time(plain, press):
    """Tell whether one press of many takes no longer than it may, in ms, beside a plain request.

    A machine busy with other work is slow at either; a stop that waits is slow each time.
    """
    return until(lambda: press() < WITHIN_MS + 2 * plain())


def milliseconds(work):
    begun = time.monotonic()
    work()
    return 1e3 * (time.monotonic() - begun)


@pytest.fixture(scope="module")
def browser():
    with Browser() as made:
        yield made


def test_a_browser_follows_loses_and_finds_the_page_and_stops_the_robot(browser):
    stops = []
    session, step = session_in_progress()
    with Page(HTML, lambda: stops.append(1)) as page:
        page.publish(state_of(session, step, "holds"))
        browser.opens(page.url)
        browser.sees("#link", "live")
        browser.sees("#aim", "incline" if step.kind == "station" else "bend")
        assert browser.runs("return document.querySelectorAll('#picture circle').length") == len(
            session.kept
        )
        session, step = session_in_progress(14)
        page.publish(state_of(session, step, "holds"))
        browser.sees("#last", session_last(session))
        browser.clicks("#stop")
        browser.sees("#told", "the robot has stopped")
        assert len(stops) == 1
        page.publish(state_of(session, step, "stopped"))
        browser.sees("#told", "stopped, until released at the terminal")
        page.publish(state_of(session, step, "holds"))
        browser.waits_for("document.querySelector('#told').textContent === ''")
        port, token = page.port, page.token
    browser.sees("#link", "connection lost")
    again = Page(HTML, None, port=port)
    again.token = token
    with again:
        again.publish(state_of(session, step, "by hand"))
        browser.sees("#link", "live")
        browser.sees("#stop", "robot by hand")
        assert browser.runs("return document.querySelector('#stop').disabled")


def session_last(session):
    return f"{session.numbered[-1].number}: "


PLAIN = """
const begun = performance.now();
return fetch(location.href).then(answer => answer.text()).then(() => performance.now() - begun)
"""
PRESS = """
return new Promise(done => {
  const told = document.querySelector('#told'), begun = performance.now();
  new MutationObserver(() => {
    if (told.textContent === 'the robot has stopped') done(performance.now() - begun);
  }).observe(told, {childList: true, characterData: true, subtree: true});
  document.querySelector('#stop').click();
})
"""


def test_stop_in_a_browser_reaches_the_moving_robot_within_200_ms(browser):
    """From the click to the board's own word that it has stopped."""
    session, step = session_in_progress(3)
    with SessionRobot("virtual") as seat, Page(HTML, seat.halt) as page:
        page.publish(state_of(session, step, "holds"))
        browser.opens(page.url)
        browser.sees("#link", "live")

        def plain():
            return browser.runs(PLAIN) + milliseconds(seat.tick)

        def press():
            seat.go(GAIT)
            assert seat._robot.status().state == "gait"
            took_ms = browser.runs(PRESS)
            assert seat._robot.status().state == "hold"
            seat.release()
            return took_ms

        assert in_time(plain, press)


@pytest.mark.parametrize(("width", "dark"), [(390, False), (390, True)])
def test_it_fits_a_phone_in_light_and_dark(tmp_path, width, dark):
    session, step = session_in_progress(30)
    with Page(HTML, lambda: None) as page, Browser(width, 844, dark) as phone:
        page.publish(state_of(session, step, "holds"))
        phone.opens(page.url)
        phone.sees("#link", "live")
        assert phone.runs("return [innerWidth, document.documentElement.clientWidth]") == [
            width,
            width,
        ]  # headless Chromium's own windows are 500 px wide at least
        assert phone.runs("return document.documentElement.scrollWidth") == width
        size = phone.runs("return parseFloat(getComputedStyle(document.body).fontSize)")
        assert size >= 18
        red = phone.runs("return getComputedStyle(document.body).backgroundColor")
        assert (red == "rgb(255, 255, 255)") is not dark
        stop = phone.runs(
            "const r = document.querySelector('#stop').getBoundingClientRect();"
            "return [r.bottom, r.height]"
        )
        assert stop[0] < 844  # to be reached without scrolling
        assert stop[1] > 60
        phone.picture(tmp_path / "phone.png")
