"""If the host program is killed while the robot is bent, the board releases the servos itself."""

from serpenoid.robot.wire.virtual import VirtualLink
from serpenoid.taking.session_robot import SessionRobot

LIMP_S = 30.0  # silence after which the board releases its servos, set by SessionRobot


def test_servos_are_released_after_a_kill():
    """A killed program sends nothing more; its clean-up, `__exit__`, does not run either."""
    link = VirtualLink(fast=True)
    robot = SessionRobot(link)
    robot.__enter__()
    robot.pose(7.5)
    for _ in range(3):  # the pose is held as long as the host sends something
        link.board.run(0.9 * LIMP_S)
        assert link.board.state == "pose"
        assert all(link.board.pulses_us)
        robot.tick()
    link.board.run(0.9 * LIMP_S)
    assert link.board.state == "pose"
    link.board.run(0.2 * LIMP_S)
    assert link.board.state == "idle"
    assert not any(link.board.pulses_us)
