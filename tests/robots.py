"""What most tests move or read: the paper's robot, that of 2005 with its session, their gaits."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import serpenoid as sn

PAPER, VISCOUS = sn.Robot(6, 1.0, 0.12), sn.Ground(0.1, 10.0)
NIRAKH_2005 = Path(__file__).resolve().parents[1] / "calibration_data" / "nirakh-2005"
OF_2005, BINGHAM = sn.Robot(6, 0.0756, 0.076), sn.Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)


def gait_in_deg(alpha_deg: float, beta_deg: float, omega_rad_s: float, *more: Any) -> sn.Gait:
    """Return a gait whose angles are given in degrees; more: as Gait takes it."""
    return sn.Gait(math.radians(alpha_deg), math.radians(beta_deg), omega_rad_s, *more)


def copy_of_2005(folder):
    """Return a copy of the session of 2005 in a new folder, without a fit."""
    return shutil.copytree(NIRAKH_2005, folder, ignore=shutil.ignore_patterns("fit.json"))
