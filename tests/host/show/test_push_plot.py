"""A push drawn in a terminal's characters: its law, what is off it, and only for a person."""

import re

import numpy as np
from calibration.floor_sessions import NEW, TRUTH, push_track
from command_line import serpenoid
from serpenoid import load_session
from serpenoid.show import screen
from serpenoid.show.session.terminal_plot import PUSH_HIGH, WIDE, push_picture


def most_mm(drawn):
    """Return how far off the law the strip reaches, in mm."""
    return float(re.search(r"█ \+(\S+) mm", drawn)[1])


def test_a_push_is_drawn_for_a_person_with_what_is_off_its_law(tmp_path, monkeypatch):
    folder, files = tmp_path / "s", []
    assert serpenoid(f"{NEW} {folder}")[0] == 0
    rows = push_track(0.9, TRUTH, np.random.default_rng(1))
    hit = push_track(0.9, TRUTH, np.random.default_rng(2))
    after = hit[:, 0] > 0.8
    hit[after, 1:] = hit[~after][-1, 1:] + 0.001 * np.sin(9.0 * hit[after, 1:])
    for name, track in (("good", rows), ("hit", hit)):
        files.append(tmp_path / f"{name}.csv")
        np.savetxt(files[-1], track, delimiter=",", header="t,x,y", comments="")
    assert "off the law" not in serpenoid(f"calibrate push {folder} {files[0]}")[1]
    monkeypatch.setattr(screen, "at_terminal", lambda: True)
    said = serpenoid(f"calibrate push {folder} {files[1]}")[1]
    good, bad = load_session(folder).of("coast")
    assert bad.voided
    assert push_picture(bad) in said
    lines = push_picture(good).splitlines()
    assert len(lines) == PUSH_HIGH + 5
    assert all(len(line) == WIDE + 8 for line in lines[:PUSH_HIGH])
    # the way is that of the reference, rolled out from 0.9 m/s
    assert 0.95 < float(lines[0].split()[0]) / 1.05 < 1.0
    assert most_mm(push_picture(good)) < 4.0  # places scatter by 1 mm
    assert most_mm(push_picture(bad)) > 8.0  # a wall


def test_what_has_no_film_is_not_drawn(tmp_path):
    folder = tmp_path / "s"
    assert serpenoid(f"{NEW} {folder}")[0] == 0
    add = f"calibrate add {folder} coast lambda_deg=0 distance_m=1"
    assert serpenoid(f"{add} duration_s=2.3")[0] == 0
    assert push_picture(load_session(folder).of("coast")[0]) == ""
