"""Predict how fast the 2005 robot crawls, and what it costs."""

import math

import serpenoid as sn

robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
gait = sn.Gait(alpha_rad=math.radians(70), beta_rad=math.radians(75), omega_rad_s=4.0)
s = sn.steady_gait(robot, ground, gait)
print(f"{s.speed_m_s:.6f} m/s (relative error {s.error_estimate:.0e}), {s.power_w * 1e3:.3f} mW")
print(f"the start is forgotten after {s.settling_time_s:.2f} s")
