"""The page of `drive --page`: its twin, and the live robot in a real browser."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from command_line import serpenoid
from robot.patience import LONG_S
from robots import BINGHAM, OF_2005, gait_in_deg
from serpenoid.robot.tools.driven_run import DrivenRun
from serpenoid.show.pages.view_page import LivePage
from webdriver import Browser

GAIT = gait_in_deg(60, 75, 3.0)


@contextmanager
def driven():
    """Drive the virtual robot beside its page; gives the run, its page and its thread."""
    run = DrivenRun(GAIT, "virtual", None)
    with LivePage(run, OF_2005, BINGHAM, "2005 robot and ground") as page:
        thread = threading.Thread(target=lambda: run.run(None, page.show))
        thread.start()
        try:
            yield run, page, thread
        finally:
            if thread.is_alive():
                run.halt()
            thread.join(LONG_S)


def test_a_phone_sees_the_robot_crawl_stops_it_and_scrubs_what_it_saw(tmp_path: Path):
    with Browser(390, 844) as phone:
        with driven() as (run, page, thread):
            phone.opens(page.url)
            phone.sees("#told", "gait; ")
            phone.waits_for("end > 2.5 && d.t_s.length > 40")
            assert phone.runs("return innerWidth") == 390
            assert phone.runs("const e = document.documentElement; return e.scrollWidth") <= 390
            # once the ramp is over the twin has the gait that was asked for
            off = phone.runs("return d.joint_deg[last].map((v, j) => v - d.asked_deg[last][j])")
            assert np.abs(off).max() < 1.0
            assert phone.runs("return d.x_m[last][0] - d.x_m[0][0]") > 0.02
            phone.clicks("#stop")
            phone.sees("#told", "stopped")
            thread.join(LONG_S)
            assert not thread.is_alive()
            assert run.halted
        phone.sees("#told", "stopped from here")
        assert phone.runs("return document.querySelector('#stop').disabled")
        phone.runs("at('when').value = 0; at('when').oninput()")
        assert phone.runs("return Math.abs(now - begin) < 1e-9 && !playing")


def test_the_command_says_where_the_page_is():
    gait = "--alpha-deg 60 --beta-deg 75 --omega-rad-s 3 --duration-s 1"
    said = serpenoid(f"drive --port virtual:fast {gait} --page", check=True).stdout
    assert "page: http://127.0.0.1:" in said
