"""Short readings: a robot that still drifts on the belt, its places fitted as a track."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from calibration.synthetic_session import WHOLE_BODY_2005
from calibration.synthetic_session import session as made_up
from calibration.synthetic_session import setup as made_up_setup
from command_line import serpenoid
from scipy.integrate import solve_ivp
from serpenoid import fit_friction, load_session
from serpenoid.session.track import TRACK, Track

NAMES = ("ct", "cn", "ft0", "fn0")
TRUE = np.array([getattr(WHOLE_BODY_2005, name) for name in NAMES])


def rolled(viscous, dry, pull, mass, belt, slip, times):
    """Return where the robot is, m uphill, by a solver that knows the equation of motion alone."""
    found = solve_ivp(
        lambda t, y: [belt - y[1], (pull - dry - viscous * y[1]) / mass],
        (0, times[-1]),
        [0.02, slip],
        t_eval=times,
        rtol=1e-11,
        atol=1e-13,
    )
    return found.y[0]


def with_short_readings():
    """Return a session whose bent stations are short, by the solver, without an error."""
    whole = made_up(made_up_setup(15.0, 30.0), WHOLE_BODY_2005)
    tools = replace(whole.setup.instruments, distance_sigma_m=0.002, time_sigma_s=0.02)
    setup = replace(whole.setup, instruments=tools)
    mass = 6 * 0.0756 * 1.045  # of wheels that nobody weighed
    times = np.linspace(0.0, 4.0, 6)

    def short(r):
        if not r.lambda_rad:
            return r
        c, s = math.cos(r.lambda_rad), math.sin(r.lambda_rad)
        viscous, dry = TRUE[0] * c * c + TRUE[1] * s * s, TRUE[2] * c + TRUE[3] * s
        pull = setup.weight_n * math.sin(r.incline_rad)
        belt = r.belt_speed_m_s + 0.05
        at = rolled(viscous, dry, pull, mass, belt, belt + 0.1, times)
        drift = (at[-1] - at[0]) / times[-1]
        track = Track.from_samples(TRACK, np.column_stack([times, at, 0.0 * at]))
        return replace(r, belt_speed_m_s=belt, drift_m_s=drift, track=track)

    return replace(whole, setup=setup, readings=tuple(map(short, whole.readings)))


def test_the_fit_finds_the_friction_of_short_readings():
    session = with_short_readings()
    fit = fit_friction(session)
    assert [fit.whole_snake[name] for name in NAMES] == pytest.approx(TRUE, rel=1e-3)
    stations = replace(session, readings=tuple(replace(r, track=None) for r in session.readings))
    assert abs(fit_friction(stations).whole_snake["fn0"] / TRUE[3] - 1) > 0.1  # not to be ignored
    assert session.sha256 != stations.sha256


def run(line):
    return serpenoid(f"calibrate {line}")


CELLS = "lambda_deg=15 incline_deg=4 belt_speed_m_s=0.5"


@pytest.mark.parametrize(
    ("typed", "kept"),
    [
        ("0:0 2:0.045 4:.13", [[0.0, 2.0, 4.0], [0.0, 0.045, 0.13]]),
        ("0:0;2,1:-0,045;4:0,13", [[0.0, 2.1, 4.0], [0.0, -0.045, 0.13]]),
        ("0:0,2:0.04,4:0.12", [[0.0, 2.0, 4.0], [0.0, 0.04, 0.12]]),
    ],
)
def test_every_way_into_a_session_takes_places(folder, tmp_path, typed, kept):
    assert run(f"add {folder} station {CELLS} 'places={typed}'").returncode == 0
    script = tmp_path / "script.toml"
    script.write_text(
        "[[reading]]\nlambda_deg = 15.0\nincline_deg = 4.4\nbelt_speed_m_s = 0.5\n"
        f'places = "{typed}"\n'
    )
    assert run(f"take {folder} --script {script}").returncode == 0
    stations = load_session(folder).kept_stations
    assert [r.track.values.T[:2].tolist() for r in stations] == [kept] * 2
    assert [r.drift_m_s for r in stations] == [kept[1][-1] / 4.0] * 2


def test_an_older_file_has_a_short_track_in_its_row(folder):
    run(f"add {folder} station {CELLS} 'places=0:0 2:0.045 4:0.13'")
    table = folder / "readings.csv"
    (track,) = (r.track for r in load_session(folder).kept_stations)
    cell = '"bend=balanced places=0:0,2:0.045,4:0.13"'
    table.write_text(re.sub(r"[^,\n]*track=\S+ track_sha256=\w+", cell, table.read_text()))
    assert load_session(folder).kept_stations[0].track.sha256 == track.sha256
