"""Track files of Tracker, Kinovea and spreadsheets: read in m and s, or refused with a reason."""

import numpy as np
import pytest
from calibration.floor_sessions import TRUTH, push_track
from calibration.track_writers import (
    METRES,
    SECONDS,
    kinovea_table,
    tracker,
)
from refusals import refused
from serpenoid.taking.track_files import read_track_file

ROWS = push_track(0.8, TRUTH, np.random.default_rng(1))
ROWS[:, 0] = np.arange(len(ROWS)) / 30
# Headings of a time in milliseconds, in the languages of Kinovea.
TIMES_MS = """\
Time (ms)|Temps (ms)|Zeit (ms)|Tiempo (ms)|Tempo (ms)|Tid (ms)|Tijd (ms)|Czas (ms)|Čas (ms)
Vreme (ms)|Vrijeme (ms)|Време (мс)|Время (мс)|Час (ms)|Χρόνος (ms)|Aika (ms)|Zaman (ms)|Masa (ms)
Waktu (ms)|Timp (ms)|Laikas (ms)|時間 (毫秒)|时间(毫秒)|時間(ms)|เวลา (ms)|Thời gian (ms)
t [ms]|time_ms|t/ms|t in ms"""
TIMES_MS = TIMES_MS.replace("\n", "|").split("|")


def read(tmp_path, text, unit=None, encoding="utf-8", name="track.csv"):
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return read_track_file(path, unit)


def equals_rows(track, atol_s=1e-4):
    np.testing.assert_allclose(track[0][:, 1:], ROWS[:, 1:], atol=2e-5)
    return np.ptp(track[0][:, 0] - ROWS[:, 0]) < atol_s


@pytest.mark.parametrize("unit", METRES)
@pytest.mark.parametrize("separator", ["\t", ";", ",", " "])
def test_units_and_separators_of_tracker(tmp_path, unit, separator):
    text = tracker(ROWS, unit, separator, comma=separator in "\t;")
    assert equals_rows(read(tmp_path, text, unit))
    with refused("no unit .*--unit or .*: one of m, cm, mm, in, ft, yd"):
        read(tmp_path, text)


@pytest.mark.parametrize("unit", METRES)
@pytest.mark.parametrize("time", TIMES_MS)
def test_units_and_languages_of_kinovea(tmp_path, unit, time):
    separator = ";" if "(" in time else ","
    assert equals_rows(read(tmp_path, kinovea_table(ROWS, unit, time, separator=separator)))


@pytest.mark.parametrize("name", SECONDS)
def test_units_of_time(tmp_path, name):
    text = kinovea_table(ROWS, time=f"Time ({name})", seconds=SECONDS[name])
    assert equals_rows(read(tmp_path, text), atol_s=1e-3)


@pytest.mark.parametrize(
    "heading",
    ["t_s,x_m,y_m", "Time [s],X [m],Y [m]", "t (s),pos_x (m),pos_y (m)", "t;x in m;y in m"],
)
def test_handwritten_headings(tmp_path, heading):
    lines = [heading, *(",".join(f"{v:.6f}" for v in row) for row in ROWS)]
    text = "\n".join(lines)
    assert equals_rows(read(tmp_path, text.replace(",", ";") if ";" in heading else text))


def test_columns_are_recognised_by_name_in_any_order(tmp_path):
    lines = ["step,v_x (m/s),y (cm),x (cm),t (s),vy (m/s)"]
    for k, (t, x, y) in enumerate(ROWS):
        lines.append(f"{k},9.0,{100 * y:.5f},{100 * x:.5f},{t:.5f},9.0")
    assert equals_rows(read(tmp_path, "\n".join(lines)))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("first", ["", "sep=;\r\n", "Bewegung größer\r\n"])
def test_encodings_and_first_lines_of_spreadsheets(tmp_path, encoding, first):
    text = first + kinovea_table(ROWS, separator=";").replace('"', "")
    assert equals_rows(read(tmp_path, text, encoding=encoding))


def test_a_note_names_the_point_that_is_used(tmp_path):
    track = read(tmp_path, tracker(ROWS, points=("head", "mass B")), "m")
    assert equals_rows(track)
    assert "the first point, x, is taken" in track[1][0]
    assert read(tmp_path, tracker(ROWS), "m")[1] == []
    flat = "\n".join(["t_s,x_m", *(f"{t},{x}" for t, x, _ in ROWS)])
    track = read(tmp_path, flat)
    assert "no column y" in track[1][0]
    assert not track[0][:, 2].any()


def test_rows_without_a_position_are_left_out(tmp_path):
    lines = kinovea_table(ROWS).split("\r\n")
    for row, empty in ((5, ""), (9, "?"), (12, "-"), (20, "--")):
        lines[row + 1] = lines[row + 1].split(",")[0] + f',"{empty}","{empty}"'
    track = read(tmp_path, "\n".join(lines))
    valid = np.delete(ROWS, [5, 9, 12, 20], axis=0)
    np.testing.assert_allclose(track[0], valid, atol=1e-4)


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        (kinovea_table(ROWS, "px"), None, "in 'px', which is no length; set the scale .*Kinovea"),
        (kinovea_table(ROWS, "px"), "cm", "in 'px', which is no length"),
        (
            kinovea_table(ROWS, time="Time (normalized)"),
            None,
            "in 'normalized', .*export the time in s or ms",
        ),
        (kinovea_table(ROWS, time="Time"), None, r"says 0.03 pictures a second.* \(Tracker"),
        (kinovea_table(ROWS, time="Time", seconds=1 / 30), None, "says 1 pictures a second"),
        (kinovea_table(ROWS, time="Time (ms)", seconds=1.0), None, r"3e\+04 pictures a second"),
        (tracker(ROWS, first="frame"), "m", "but in frames; .*Tracker: take t"),
        ("t,x,y\n0:00:01:05,1,2\n", "mm", "t is '0:00:01:05', not a number; export the time"),
        ("a,b\n1,2\n", None, "no line names .* first line is 'a,b'; .* t_s,x_m,y_m"),
        ("t,x,y\n0,1,2\n0.1,one,2\n0.2,1,2\n", "m", r"csv:3: x is 'one', not a number"),
        ("t,x,y\n0,1,2\n0.1,1,NaN\n0.2,1,2\n", "m", "csv:3: y is 'NaN', not a number"),
        ("t,x,y\n0,1,2\n", "m", "1 place in it"),
        ("t,x,y\n0,1,2\n0,1,2\n0,1,2\n", "m", "do not rise"),
        ("t,x,y\n0,0,0,1,0,2\n", "m", ":2: 6 cells where .* 3; decimals with a comma need"),
        ("", None, "the file is empty"),
    ],
)
def test_other_files_are_refused(tmp_path, text, unit, message):
    with refused(message):
        read(tmp_path, text, unit)
