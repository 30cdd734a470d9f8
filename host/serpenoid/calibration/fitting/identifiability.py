"""What the readings can tell: which parameter they leave open, and which reading would close it."""

from __future__ import annotations

import numpy as np

from ...base.errors import BadInput
from ...session.session import Session
from .stations import Stations
from .unknowns import Floats

ADVISED_LAMBDA_DEG = 15.0
# Below this many sigmas a bend is refused: sin^2 of it is no longer a number with an error but a
# guess. Below the second, cn is biased by 3 (sigma / lambda)^2 or more, 3 %, and the fit says so.
LEAST_BEND, SAFE_BEND = 5.0, 10.0
_NAMES = {"straight": ("ct", "ft0"), "bent": ("cn", "fn0")}


def check_readings(session: Session, data: Stations, least: int) -> None:
    """Raise BadInput if the readings leave a parameter open; least: readings a part needs."""
    bend = _bend_advised(data)
    sigma = float(np.median(data.speed_sigma_m_s)) if len(data) else 0.0
    straight = data.slip_m_s[data.parts["straight"]]
    _check_part(session, "straight", straight, (sigma, 1.0), least, "straight (lambda_deg = 0)")
    across = np.sin(data.lambda_rad[data.bent])
    most = float(across.max(initial=0.0))
    advised = f"with lambda_deg = {bend:g}"
    moved = data.slip_m_s[data.bent] * across
    if not _one_bend_tells(data, sigma, least):
        _check_part(session, "bent", moved, (sigma * most, most), least, advised)
    _check_bend(session, data)


def _one_bend_tells(data: Stations, sigma: float, least: int) -> bool:
    """Tell whether one bend's readings suffice alone, whatever others add."""
    bends = [data.slip_m_s[data.bends.posture == p] for p in range(len(data.bends.sigma_rad))]
    return any(len(v) >= least and np.ptp(v) >= 4.0 * sigma for v in bends)


def bend_note(data: Stations) -> list[str]:
    """Say how far the bend's own error biases cn, where it does."""
    sigma = np.where(data.bends.sigma_rad > 0.0, data.bends.sigma_rad, np.nan)
    ratio = float(np.nanmax(data.bends.angle_rad / sigma, initial=-np.inf))
    if not 0.0 < ratio < SAFE_BEND:
        return []
    return [
        f"The bend is only {ratio:.1f} of its standard deviations: cn comes out too large by about "
        f"{3 / ratio**2:.0%} on average, until a bend of {_bend_advised(data):g} degrees is held."
    ]


def _bend_advised(data: Stations) -> float:
    sigma = float(data.bends.sigma_rad.max(initial=0.0))
    return max(ADVISED_LAMBDA_DEG, float(np.ceil(np.degrees(sigma) * SAFE_BEND)))


def _check_part(
    session: Session, part: str, speed_m_s: Floats, unit: tuple[float, float], least: int, how: str
) -> None:
    """Check readings and their speeds' span; unit: a speed's sigma and the belt's share in it."""
    sigma_m_s, share = unit
    first, second = _NAMES[part]
    if len(speed_m_s) < least:
        raise BadInput(
            f"{session.where}: {first} and {second} cannot be told from {len(speed_m_s)} {part} "
            f"reading(s); they need at least {least}, {how}, at belt speeds far apart (0.2 and "
            "0.8 m/s, say); take more"
        )
    # With less than this between the slowest and the fastest, the noise of the speeds alone could
    # draw the line, and no interval from a linearised fit would be honest.
    spread_m_s, needed = float(np.ptp(speed_m_s)), 4.0 * sigma_m_s
    if spread_m_s < needed:
        belt = (float(speed_m_s.min()) + 2.0 * needed) / (share or 1.0)
        raise BadInput(
            f"{session.where}: {first} and {second} cannot be told apart: the {part} readings' "
            f"speeds along their line span {spread_m_s:.3g} m/s, and must span at least four "
            f"standard deviations, {needed:.3g} m/s; a reading {how} at another incline, with the "
            f"belt near {belt:.2g} m/s, would do it"
        )


def _check_bend(session: Session, data: Stations) -> None:
    with np.errstate(divide="ignore"):
        ratio = data.bends.angle_rad / data.bends.sigma_rad
    if ratio.max() > LEAST_BEND:
        return
    best = int(ratio.argmax())
    shown, sigma = np.degrees([data.bends.angle_rad[best], data.bends.sigma_rad[best]])
    raise BadInput(
        f"{session.where}: cn and fn0 cannot be told: lambda_deg is {shown:g} with a standard "
        f"deviation of {sigma:g}; a bend must be more than {LEAST_BEND:g} of these from straight; "
        f"two readings with lambda_deg = {_bend_advised(data):g} would do it"
    )
