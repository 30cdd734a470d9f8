"""Find the cheapest gait for a few speeds, as in the paper's Figs. 8 to 11."""

import math

import serpenoid as sn

robot, ground = sn.Robot(6, 1.0, 0.12), sn.Ground(ct=0.1, cn=10.0)
for speed in (0.1, 0.3, 0.5):
    best = sn.least_power_gait(robot, ground, speed_m_s=speed)
    alpha, beta = math.degrees(best.gait.alpha_rad), math.degrees(best.gait.beta_rad)
    print(
        f"{speed:.1f} m/s: alpha {alpha:.2f} deg, beta {beta:.2f} deg, "
        f"omega {best.gait.omega_rad_s:.4f} rad/s, {best.power_w * 1e3:.4f} mW"
    )
