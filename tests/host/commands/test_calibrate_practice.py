"""`calibrate practice` as it is typed: the real dialogue, the firmware's controller, the lab."""

from __future__ import annotations

import re
import subprocess
import urllib.error
import urllib.request

import pytest
from command_line import program, serpenoid
from serpenoid.calibration.session_file import read_session

TYPED = """inclinometer
turned
0.1
0.1

incline 4
belt 1.6
put
look

y
wait 1
2.3
1.6km/h

n
quit
quit
"""


def practise(folder, more, typed=TYPED):
    return serpenoid(f"calibrate practice {folder} {more} --pace 20", typed=typed)


def test_a_station_is_held_at_the_desk_and_the_session_resumed(tmp_path):
    folder = tmp_path / "desk"
    done = practise(folder, "--seed 3 --no-page")
    assert done.returncode == 0, done.stderr
    assert "#####O" in done.stdout  # the robot on the belt
    assert "inclinometer, turned" in done.stdout
    assert "http" not in done.stdout
    session = read_session(folder)
    assert session.setup.kind == "simulated"
    assert session.setup.source == "practice treadmill, seed 3"
    assert session.zeros
    again = practise(folder, "--no-page", typed="treadmill\nquit\n")
    assert again.returncode == 0
    assert "wait 20" in again.stdout
    other = practise(folder, "--seed 4", typed="")
    assert other.returncode == 2
    assert "is of seed 3" in other.stderr


def test_a_session_of_a_real_robot_is_not_practised_on(tmp_path):
    folder = tmp_path / "real"
    serpenoid(f"calibrate new {folder} --defaults --surface belt --mass-kg 480g", check=True)
    done = practise(folder, "--no-page")
    assert done.returncode == 2
    assert "no session of practice" in done.stderr


def test_the_page_shows_the_robot_and_its_buttons_work(tmp_path):
    command = program(f"calibrate practice {tmp_path}/p")
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        url = ""
        for line in process.stdout:
            if found := re.search(r"http://\S+", line):
                url = found[0]
                break
        assert "practice treadmill" in urllib.request.urlopen(url, timeout=10).read().decode()

        def press(name):
            request = urllib.request.Request(
                url + name, method="POST", headers={"Origin": url.rsplit("/", 2)[0]}
            )
            return urllib.request.urlopen(request, timeout=10).read().decode()

        assert "0.1 km/h" in press("faster")
        assert "on the belt" in press("put")
        with urllib.request.urlopen(url + "states", timeout=10) as stream:
            state = next(line for line in stream if b'"lies": true' in line)
        assert b'"chain"' in state
        with pytest.raises(urllib.error.HTTPError):
            press("explode")
        process.stdin.close()
        process.stdout.read()
    assert process.returncode == 0
