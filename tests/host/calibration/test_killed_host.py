"""A program that is killed while the robot lies bent: the board itself lets go of the servos."""

from serpenoid.robot.wire.virtual import VirtualLink
from serpenoid.taking.session_robot import LIMP_S, SessionRobot


def test_after_a_kill_a_held_pose_is_let_go():
    """A killed program says nothing more, and does nothing of what it would do at its end."""
    link = VirtualLink(fast=True)
    robot = SessionRobot(link)
    robot.__enter__()
    robot.pose(7.5)
    for _ in range(3):  # while the host says something each half second, the pose is held
        link.board.run(0.9 * LIMP_S)
        assert link.board.state == "pose"
        assert all(link.board.pulses_us)
        robot.tick()
    link.board.run(0.9 * LIMP_S)
    assert link.board.state == "pose"
    link.board.run(0.2 * LIMP_S)
    assert link.board.state == "idle"
    assert not any(link.board.pulses_us)
