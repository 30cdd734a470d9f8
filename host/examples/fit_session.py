"""Fit friction to a treadmill session and carry its uncertainty to a speed."""

from pathlib import Path

import serpenoid as sn

folder = Path(__file__).resolve().parent
places = [folder / "calibration_data", folder.parents[1] / "calibration_data"]
session = sn.load_session(next(p for p in places if p.exists()) / "nirakh-2005")
fit = sn.fit_friction(session)
print(fit)
s = sn.steady_gait(session.setup.robot, fit.ground, sn.Gait(1.22, 1.31, 5.0))
print(f"predicted speed: {s.speed_m_s:.4f} m/s")
