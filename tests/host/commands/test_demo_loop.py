"""The demo's treatment of a misread value, which its own seed does not need."""

import pytest
from serpenoid import BadInput, fit_friction, load_session
from serpenoid.calibration.taking.journal import Journal
from serpenoid.commands.demo_parts.loop import _without_outlier, take_session


def test_a_misread_value_is_found_and_voided(tmp_path):
    session = take_session(tmp_path / "session")
    clean = fit_friction(session)
    assert _without_outlier(session, clean) == (session, clean, "")
    wrong = session.kept[4]
    with Journal(tmp_path / "session") as journal:
        journal.add(
            "station",
            {
                "lambda_deg": 0.0,
                "incline_deg": 2.6,
                "belt_speed_m_s": 1.9,
                "drift_m_s": 0.0,
            },
            replaces=wrong.number,
        )
        number = journal.numbers[-1]
        session = journal.session
    mended, fit, words = _without_outlier(session, fit_friction(session))
    assert f"without reading {number}:" in words
    assert number not in [r.number for r in mended.kept]
    assert fit.p_value > 0.01
    assert load_session(tmp_path / "session").readings[-1].voided


def test_another_session_is_not_taken_for_the_demos(tmp_path):
    from serpenoid.calibration.taking.new_session import create_session, default_setup

    create_session(tmp_path / "session", default_setup("mine"))
    with pytest.raises(BadInput, match="not the demo's"):
        take_session(tmp_path / "session")


def test_a_robot_of_ones_own_is_the_truth(tmp_path):
    from dataclasses import replace

    from serpenoid import Ground, Robot
    from serpenoid.calibration.session_file import read_session
    from serpenoid.commands.demo_parts.loop import TRUTH

    ground = Ground(ct=0.12, cn=2.0, ft0=0.1, fn0=0.4)
    own = Robot(6, 0.1, 0.09)
    session = take_session(tmp_path / "session", replace(TRUTH, ground=ground, misreads=0.0), own)
    assert session.setup.robot == own
    for row, true in zip(fit_friction(session).rows(), (0.12, 2.0, 0.1, 0.4), strict=True):
        assert abs(row.value - true) < 3.5 * row.sigma
    assert read_session(tmp_path / "session").setup.kind == "simulated"
