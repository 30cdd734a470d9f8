"""A track of a session that was changed, or lost, since it was taken."""

from command_line import serpenoid
from refusals import refused
from serpenoid import load_session


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
