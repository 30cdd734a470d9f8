"""Drive a robot, here the firmware's own controller in this process; name a port for a real one."""

import math
from pathlib import Path

from serpenoid import Gait
from serpenoid.robot import RobotBoard
from serpenoid.robot.recording.stream import load_stream

recording = Path("virtual_robot.wire")
recording.unlink(missing_ok=True)  # of an earlier run: nothing else is ever written over
gait = Gait.degrees(30, 80, omega_rad_s=5.0)
with RobotBoard("virtual:fast", record=recording) as robot:  # leaving the block stops the robot
    robot.straight()
    robot.gait(gait)
    for frame in robot.frames(10.0):
        if frame.frame % 100 == 0:
            print(frame.state, [round(math.degrees(a), 1) for a in frame.setpoint_rad])
    rate_rad_s, sd_rad_s = robot.clock.true_rate(gait.omega_rad_s)
    print(f"true rate {rate_rad_s:.6f} +- {sd_rad_s:.6f} rad/s, {robot.losses}")

stream = load_stream(recording)
pulses = stream.pulse_us[stream.pulse_us > 0]  # 0: not attached yet, one servo follows the other
print(f"{len(stream.frame)} frames, pulses {pulses.min()} to {pulses.max()} us")
