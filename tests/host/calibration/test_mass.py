"""The robot of a session: a mass that is corrected, and one that nobody has weighed."""

import math
from dataclasses import replace

import pytest
from robots import NIRAKH_2005
from serpenoid import fit_friction, load_session
from serpenoid.session.folder import write_setting
from serpenoid.session.journal import Journal
from serpenoid.taking.new_session import answered, create_session, default_setup

ZERO = {"incline_deg": 0.1, "reversed_deg": -0.1}


@pytest.fixture
def folder(tmp_path):
    made = create_session(
        tmp_path / "session", answered(default_setup("made up"), {"surface": "belt"})
    )
    with Journal(made) as journal:
        journal.add("zero", ZERO)
    return made


def test_a_corrected_mass_holds_for_readings_taken_before(folder):
    with Journal(folder) as journal:
        for bend, incline, belt in (
            (0, 2, 0.3),
            (0, 3, 1.0),
            (15, 3.0, 0.1),
            (15, 4.0, 0.5),
            (15, 5.0, 0.9),
        ):
            cells = {"lambda_deg": bend, "incline_deg": incline, "belt_speed_m_s": belt}
            journal.add("station", cells | {"drift_m_s": 0.0})
        before = fit_friction(journal.session)
        write_setting(folder, "robot", "mass_kg", 0.49896)
        assert journal.read_again() == ["robot.mass_kg is 0.49896 now; it was 0.4536"]
        after = fit_friction(journal.session)
    assert after.parameters["ct"].value == pytest.approx(1.1 * before.parameters["ct"].value)
    assert before.session_sha256 != after.session_sha256


def test_an_unweighed_robot_has_frictions_as_doubtful_as_its_mass():
    """A twentieth, beside what readings leave open."""
    session = load_session(NIRAKH_2005)
    body = session.setup.robot_table
    setups = [
        replace(session.setup, robot_table=replace(body, mass_kg=mass_kg))
        for mass_kg in (body.mass_kg, None)
    ]
    assert "g ± 0 %" in setups[0].in_words()
    assert "g ± 5 %" in setups[1].in_words()
    weighed, unweighed = (fit_friction(replace(session, setup=setup)) for setup in setups)
    for name, (value, sigma) in weighed.parameters.items():
        more = math.sqrt(unweighed.parameters[name].sigma ** 2 - sigma**2)
        assert more > 0.045 * value
    assert any("was not weighed" in note for note in unweighed.notes)
