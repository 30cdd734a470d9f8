"""A reading through files, tables and the hash of its session; a track that was changed."""

import math

import pytest
from command_line import serpenoid
from refusals import refused
from serpenoid import load_session

PUSHED = "calibrate add {0} push lambda_deg={1} distance_m=0.8 duration_s=1.5"


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "session"
    serpenoid(f"calibrate new {folder} --defaults --surface wood --mass-kg 480g", check=True)
    return folder


def test_a_reading_is_kept_shown_voided_and_hashed(folder):
    serpenoid(PUSHED.format(folder, 0), check=True)
    first = load_session(folder).sha256
    more = "turned_deg=2,5 way=back"
    serpenoid(f"{PUSHED.format(folder, 20)} {more}", check=True)
    session = load_session(folder)
    assert session.sha256 != first
    push = session.kept_pushes[1]
    assert (push.way, push.number) == ("back", 2)
    assert push.turned_rad == pytest.approx(math.radians(2.5))
    shown = serpenoid(f"calibrate status {folder}").stdout
    assert "push back, bend 20°" in shown
    serpenoid(f"calibrate void {folder} 2 --reason 'hit a chair'", check=True)
    session = load_session(folder)
    assert session.readings_of("push")[1].voided
    assert session.sha256 == first
    header = (folder / "readings.csv").read_text().splitlines()[0]
    assert "turned_deg" not in header  # old programs still read the file


def test_a_track_that_was_changed_or_lost_is_told(folder, tmp_path):
    table = tmp_path / "push.csv"
    ways = [0.9 * t - 0.3 * t * t if t < 1.5 else 0.675 for t in (k / 30 for k in range(60))]
    rows = [f"{k / 30:.4f},{way:.5f},0" for k, way in enumerate(ways)]
    table.write_text("\n".join(["t_s,x_m,y_m", *rows]) + "\n")
    serpenoid(f"calibrate push {folder} {table}", check=True)
    assert len(load_session(folder).kept_pushes[0].track.values) == len(rows)
    path = folder / "tracks" / "0001.csv"
    path.write_text(path.read_text().replace("0.0", "0.1", 1))
    with refused(r"0001.csv: the track was changed since it was taken"):
        load_session(folder)
    path.unlink()
    with refused(r"0001.csv: the track is not there"):
        load_session(folder)
