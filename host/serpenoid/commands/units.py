"""Figures that look as if typed in another unit: told, not refused, as they may be meant."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

_LONG_M, _HEAVY_KG = 3.0, 50.0  # of one link: beyond what anybody puts on wheels
_FAST_RAD_S = 60.0  # ten waves a second


def doubt_robot(given: Mapping[str, Any]) -> None:
    """Warn of links whose length or mass, of the options given, looks like mm or g."""
    for name, most, unit, small in (
        ("length_m", _LONG_M, "m", "mm"),
        ("mass_kg", _HEAVY_KG, "kg", "g"),
    ):
        value = given.get(name)
        if value is not None and most < value < math.inf:
            _tell(
                f"--{name.replace('_', '-')}", f"{value:g} {unit} for one link", small, value / 1e3
            )


def doubt_gait(given: Mapping[str, Any]) -> None:
    """Warn of a gait whose options look like radians, degrees a second or turns a minute."""
    alpha, beta = given.get("alpha_deg"), given.get("beta_deg")
    if alpha and beta and 0 < alpha <= math.pi and abs(beta) <= math.pi:
        told = f"{alpha:g} and {beta:g} degrees"
        _tell("--alpha-deg, --beta-deg", told, "radians", math.degrees(alpha), math.degrees(beta))
    omega = given.get("omega_rad_s")
    if omega is not None and _FAST_RAD_S < omega < math.inf:
        told = f"{omega:g} rad/s, {omega / math.tau:.3g} waves a second"
        _tell("--omega-rad-s", told, "degrees a second", math.radians(omega))


def _tell(option: str, value: str, unit: str, *meant: float) -> None:
    typed = " and ".join(f"{number:.4g}" for number in meant)
    warnings.warn(f"{option}: {value}? If {unit} were meant, type {typed}", stacklevel=3)
