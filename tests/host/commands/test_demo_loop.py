"""The demo's session: no other is taken for it, and a robot of one's own is its truth."""

from refusals import refused
from serpenoid import fit_friction
from serpenoid.commands.demo_loop import take_session


def test_another_session_is_not_taken_for_the_demos(tmp_path):
    from serpenoid.taking.new_session import create_session, default_setup

    create_session(tmp_path / "session", default_setup("mine"))
    with refused("not the demo's"):
        take_session(tmp_path / "session")


def test_a_robot_of_ones_own_is_the_truth(tmp_path):
    from dataclasses import replace

    from serpenoid import Ground, Robot
    from serpenoid.commands.demo_loop import TRUTH
    from serpenoid.session.folder import read_session

    ground = Ground(ct=0.12, cn=2.0, ft0=0.1, fn0=0.4)
    own = Robot(6, 0.1, 0.09)
    session = take_session(tmp_path / "session", replace(TRUTH, ground=ground, misreads=0.0), own)
    assert session.setup.robot == own
    for row, true in zip(fit_friction(session).rows(), (0.12, 2.0, 0.1, 0.4), strict=True):
        assert abs(row.value - true) < 3.5 * row.sigma
    assert read_session(tmp_path / "session").setup.kind == "simulated"
