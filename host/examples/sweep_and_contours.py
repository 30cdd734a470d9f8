"""Sweep amplitude and phase lag, and draw the speed over both as contours."""

import numpy as np
import serpenoid as sn
from matplotlib.figure import Figure

robot, ground = sn.Robot(6, 1.0, 0.12), sn.Ground(ct=0.1, cn=10.0)
alpha_deg, beta_deg = np.arange(5.0, 76.0, 2.5), np.arange(20.0, 131.0, 2.5)
grid = sn.sweep(
    robot, ground, alpha_rad=np.radians(alpha_deg), beta_rad=np.radians(beta_deg), omega_rad_s=3.0
)
speed = np.where(grid.converged, grid.speed_m_s, np.nan)[:, :, 0]
i, j = np.unravel_index(np.nanargmax(speed), speed.shape)
print(
    f"fastest at 5 rad/s: {speed[i, j]:.3f} m/s, "
    f"alpha {alpha_deg[i]:g} deg, beta {beta_deg[j]:g} deg"
)

figure = Figure(figsize=(6, 4.5), layout="constrained")
ax = figure.subplots()
lines = ax.contour(beta_deg, alpha_deg, speed, levels=12, cmap="viridis")
ax.clabel(lines, lines.levels[2::2], fmt="%.2f")
ax.plot(beta_deg[j], alpha_deg[i], "k*", ms=10)
best = f"★ {speed[i, j]:.3f} m/s at α = {alpha_deg[i]:g}°, β = {beta_deg[j]:g}°"
ax.set(xlabel="phase lag β (°)", ylabel="amplitude α (°)")
ax.set_title(f"speed (m/s) of the paper's robot at ω = 5 rad/s; fastest: {best}", fontsize=9)
figure.savefig("speed_contours.png", dpi=160)
print("drawn in speed_contours.png")
