"""Short readings: positions of a robot that still drifts on the belt, fitted as a track."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from calibration import synthetic_session as synthetic
from command_line import serpenoid
from scipy.integrate import solve_ivp
from serpenoid import fit_friction, load_session
from serpenoid.session.track import TRACK, Track

NAMES = ("ct", "cn", "ft0", "fn0")
TRUE = np.array([getattr(synthetic.WHOLE_BODY_2005, name) for name in NAMES])


def uphill_positions(viscous, dry, pull, mass, belt, slip, times):
    """Return the robot's positions, m uphill, from the equation of motion and SciPy's solver."""
    solution = solve_ivp(
        lambda t, y: [belt - y[1], (pull - dry - viscous * y[1]) / mass],
        (0, times[-1]),
        [0.02, slip],
        t_eval=times,
        rtol=1e-11,
        atol=1e-13,
    )
    return solution.y[0]


def session_of_short_readings():
    """Return a session whose bent stations have short, exact tracks in place of a balance."""
    balanced = synthetic.session(synthetic.setup(15.0, 30.0), synthetic.WHOLE_BODY_2005)
    tools = replace(balanced.setup.instruments, distance_sigma_m=0.002, time_sigma_s=0.02)
    setup = replace(balanced.setup, instruments=tools)
    mass = 6 * 0.0756 * 1.045  # kg; wheels that nobody weighed add 4.5 %
    times = np.linspace(0.0, 4.0, 6)

    def short_reading(r):
        if not r.lambda_rad:
            return r
        c, s = math.cos(r.lambda_rad), math.sin(r.lambda_rad)
        viscous, dry = TRUE[0] * c * c + TRUE[1] * s * s, TRUE[2] * c + TRUE[3] * s
        pull = setup.weight_n * math.sin(r.incline_rad)
        belt = r.belt_speed_m_s + 0.05
        position = uphill_positions(viscous, dry, pull, mass, belt, belt + 0.1, times)
        drift = (position[-1] - position[0]) / times[-1]
        track = Track.from_samples(TRACK, np.column_stack([times, position, 0.0 * position]))
        return replace(r, belt_speed_m_s=belt, drift_m_s=drift, track=track)

    return replace(balanced, setup=setup, readings=tuple(map(short_reading, balanced.readings)))


def test_the_fit_finds_the_friction_of_short_readings():
    session = session_of_short_readings()
    fit = fit_friction(session)
    assert [fit.whole_snake[name] for name in NAMES] == pytest.approx(TRUE, rel=1e-3)
    stations = replace(session, readings=tuple(replace(r, track=None) for r in session.readings))
    assert abs(fit_friction(stations).whole_snake["fn0"] / TRUE[3] - 1) > 0.1  # drift matters
    assert session.sha256 != stations.sha256


def run(line):
    return serpenoid(f"calibrate {line}")


CELLS = "lambda_deg=15 incline_deg=4 belt_speed_m_s=0.5"


@pytest.mark.parametrize(
    ("cell", "samples"),
    [
        ("0:0;2,1:-0,045;4:0,13", [[0.0, 2.1, 4.0], [0.0, -0.045, 0.13]]),
        ("0:0,2:0.04,4:.12", [[0.0, 2.0, 4.0], [0.0, 0.04, 0.12]]),
    ],
)
def test_add_and_a_script_take_positions(folder, tmp_path, cell, samples):
    assert run(f"add {folder} station {CELLS} 'places={cell}'").returncode == 0
    script = tmp_path / "script.toml"
    script.write_text(
        "[[reading]]\nlambda_deg = 15.0\nincline_deg = 4.4\nbelt_speed_m_s = 0.5\n"
        f'places = "{cell}"\n'
    )
    assert run(f"take {folder} --script {script}").returncode == 0
    stations = load_session(folder).kept_stations
    assert [r.track.values.T[:2].tolist() for r in stations] == [samples] * 2
    assert [r.drift_m_s for r in stations] == [samples[1][-1] / 4.0] * 2


def test_an_older_file_with_the_positions_in_a_cell_loads(folder):
    run(f"add {folder} station {CELLS} 'places=0:0 2:0.045 4:0.13'")
    table = folder / "readings.csv"
    (track,) = (r.track for r in load_session(folder).kept_stations)
    cell = '"bend=balanced places=0:0,2:0.045,4:0.13"'
    table.write_text(re.sub(r"[^,\n]*track=\S+ track_sha256=\w+", cell, table.read_text()))
    assert load_session(folder).kept_stations[0].track.sha256 == track.sha256
