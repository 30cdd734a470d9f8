"""The journal: kills, cut lines, two writers and full disks cost one reading at most."""

import os
import random
import resource
import signal
import subprocess
import sys
import time

import pytest
from calibration.test_session import rewrite
from refusals import refused
from serpenoid.base.errors import RecordingFailed
from serpenoid.session.folder import read_session
from serpenoid.session.journal import Journal, append_line

STATION = {"lambda_deg": 0.0, "incline_deg": 2.5, "belt_speed_m_s": 0.4, "drift_m_s": 0.0}


def child(folder, body):
    """Run Python with an open journal; returns the process."""
    script = (
        "import sys, time\n"
        "from serpenoid.session.journal import Journal\n"
        f"with Journal({str(folder)!r}) as journal:\n{body}"
    )
    return subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)


def test_what_is_added_is_on_disk_at_once(folder):
    with Journal(folder) as journal:
        assert journal.add("station", STATION, comment="two\nlines, with a comma") == 1
        assert read_session(folder).kept_stations[0].comment == "two lines, with a comma"
        journal.add("station", STATION | {"belt_speed_m_s": 0.5}, replaces=1)
        assert [r.number for r in journal.session.kept_stations] == [2]
        journal.event("undo", 2)
        assert [r.number for r in journal.session.kept_stations] == [1]
    assert [r.number for r in read_session(folder).kept_stations] == [1]


def test_corrections_of_what_is_not_there_are_refused(folder):
    with Journal(folder) as journal:
        with refused("there is no reading 3"):
            journal.event("void", 3)
        with refused("there is no reading 3"):
            journal.add("station", STATION, replaces=3)
    assert len((folder / "events.csv").read_text().splitlines()) == 1


def test_a_second_writer_is_refused_by_the_first_ones_number(folder):
    process = child(folder, "    print('in', flush=True); time.sleep(60)\n")
    try:
        assert process.stdout.readline() == "in\n"
        with refused(f"process {process.pid} is writing"), Journal(folder):
            pass
        assert read_session(folder).setup.name == "made up"  # reading is free
    finally:
        process.kill()
        process.wait()
    with Journal(folder) as journal:  # a killed writer's lock is gone
        journal.add("station", STATION)


@pytest.mark.parametrize("seed", range(4))
def test_killed_at_any_moment_at_most_the_one_being_written_is_lost(folder, seed):
    body = f"    while True:\n        print(journal.add('station', {STATION!r}), flush=True)\n"
    process = child(folder, body)
    told = int(process.stdout.readline())
    time.sleep(random.Random(seed).uniform(0.0, 0.1))
    process.send_signal(signal.SIGKILL)
    for line in process.stdout:
        if line.endswith("\n"):
            told = int(line)
    process.wait()
    kept = [r.number for r in read_session(folder).kept_stations]
    assert kept == list(range(1, len(kept) + 1))
    assert len(kept) in (told, told + 1)
    with Journal(folder) as journal:
        assert journal.add("station", STATION) == len(kept) + 1


@pytest.mark.parametrize("cut", range(1, 40, 3))
def test_a_line_that_was_cut_short_is_closed_and_the_next_one_whole(folder, cut):
    with Journal(folder) as journal:
        journal.add("station", STATION)
        journal.add("station", STATION, comment="x")
    path = folder / "readings.csv"
    os.truncate(path, path.stat().st_size - cut)
    with Journal(folder) as journal:
        assert len(journal.session.kept_stations) == 1
        assert journal.add("station", STATION) == 2
        assert len(journal.session.kept_stations) == 2
        assert not journal.session.notes


def test_a_full_disk_leaves_every_earlier_reading_and_nothing_half_written(folder):
    with Journal(folder) as journal:
        journal.add("station", STATION)
        path = folder / "readings.csv"
        before = path.read_bytes()
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 10, hard))
        try:
            with pytest.raises(RecordingFailed, match="not saved, all before it is; make room"):
                journal.add("station", STATION)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        assert path.read_bytes() == before
        assert journal.add("station", STATION) == 2


def test_a_setting_that_is_corrected_meanwhile_is_told(folder):
    with Journal(folder) as journal:
        rewrite(folder / "session.toml", "mass_kg = 0.4536", "mass_kg = 0.49896")
        assert journal.read_again() == ["robot.mass_kg is 0.49896 now; it was 0.4536"]
        assert journal.session.setup.robot.mass_kg == pytest.approx(0.49896)


def test_links_that_changed_after_readings_are_told(folder):
    with Journal(folder) as journal:
        journal.add("station", STATION)
        assert not journal.session.notes
        rewrite(folder / "session.toml", "links = 6", "links = 8")
        journal.read_again()
        assert (
            "readings 1 were taken when session.toml said 6 links; a fit takes 8"
            in journal.session.notes[0]
        )
        journal.add("station", STATION)
        assert len(journal.session.notes) == 1


def test_no_file_at_all_is_told(tmp_path):
    with pytest.raises(RecordingFailed, match="this is not saved"):
        append_line(tmp_path / "none.csv", "x\n")
    with refused(r"no session here.*calibrate new"), Journal(tmp_path):
        pass
