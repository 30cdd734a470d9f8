"""Whether readings tell all frictions: which one they leave open, and what would close it."""

from __future__ import annotations

import math

import numpy as np

from ..base.errors import BadInput
from ..session.session import Session
from .parameters import Floats
from .posterior import MapEstimate
from .stations import Stations

ADVISED_LAMBDA_DEG = 15.0
# Below the first a bend is refused: sin^2 of it is no longer a number with an error but a guess.
# Below the second, cn is biased by 3 (sigma / lambda)^2 or more, 3 %, and the fit says so.
MIN_BEND_SIGMAS, SAFE_BEND_SIGMAS = 5.0, 10.0
# Between the slowest and the fastest reading. With less the noise of the speeds alone could draw
# the line, and no interval from a linearised fit would be honest.
MIN_SPAN_SIGMAS = 4.0
OPEN = 0.5  # relative error of all the force there is, above which a friction is not told
WEAK_PRIOR = 1e-6  # information that leaves an open friction a vast error


def check_readings(session: Session, stations: Stations, least: int) -> None:
    """Raise BadInput if stations leave a friction open; least: readings that a part needs."""
    bent, sigma = stations.bent, stations.speed_sigma_m_s
    _check_part(session, stations.slip_m_s[~bent], least, "straight", (sigma, 1.0))
    slip_m_s, posture = stations.slip_m_s[bent], stations.bends.posture[bent]
    by_bend = [slip_m_s[posture == k] for k in range(len(stations.bends.angle_rad))]
    span = MIN_SPAN_SIGMAS * sigma
    if not any(len(slips) >= least and np.ptp(slips) >= span for slips in by_bend):
        across = np.sin(stations.lambda_rad[bent])
        share = float(across.max(initial=0.0))
        _check_part(session, slip_m_s * across, least, "bent", (sigma * share, share))
    sigma_rad = session.setup.instruments.lambda_sigma_rad
    largest = max(stations.bends.angle_rad)
    if largest <= MIN_BEND_SIGMAS * sigma_rad:
        raise BadInput(
            f"{session.where}: cn and fn0 cannot be told: lambda_deg is "
            f"{math.degrees(largest):g} with a standard deviation of {math.degrees(sigma_rad):g}; "
            f"a bend must be more than {MIN_BEND_SIGMAS:g} of these from straight; two readings "
            f"with lambda_deg = {_advised_deg(session):g} would do it"
        )


def bend_note(session: Session) -> str:
    """Return how far the bend's own error biases cn; "" where it does not."""
    sigma_rad = session.setup.instruments.lambda_sigma_rad
    largest = max((reading.lambda_rad for reading in session.kept), default=0.0)
    if not 0.0 < largest < SAFE_BEND_SIGMAS * sigma_rad:
        return ""
    ratio = largest / sigma_rad
    return (
        f"The bend is only {ratio:.1f} of its standard deviations: cn comes out too large by about "
        f"{3 / ratio**2:.0%} on average, until a bend of {_advised_deg(session):g} degrees is held."
    )


def check_floor(session: Session, estimate: MapEstimate) -> None:
    """Raise BadInput if a friction's error is as large as all the force there is on a floor."""
    from .pushes import Pushes

    pushes = session.kept_pushes
    fast = max(track.pushed_m_s for track in Pushes.of(session).tracks)
    pairs = [
        ("ct and ft0", 0, 2, "pushes of the straight robot at 0.9 m/s, both ways, filmed"),
        ("cn and fn0", 1, 3, "pushes in the balanced bend of 42 degrees, both ways, filmed"),
    ]
    if not any(reading.lambda_rad for reading in session.fitted):
        pairs.reverse()  # fn0 is then boundless, and ft0 with it where links stand off a little
    information = estimate.slopes.T @ estimate.slopes
    covariance = np.linalg.inv(information + WEAK_PRIOR * np.eye(len(information)))
    sigma = np.sqrt(np.diag(covariance))
    for names, viscous, dry, cure in pairs:
        force = max(estimate.x[viscous] * fast + estimate.x[dry], 1e-9)
        off = max(sigma[viscous] * fast, sigma[dry]) / force
        if not off <= OPEN:
            by = f"are open by {off:.0%} of the force" if off < 1.0 else "stay wholly open"
            raise BadInput(
                f"{session.where}: {names} cannot be told from {len(pushes)} push(es): they {by}; "
                f"take {cure}"
            )


def _advised_deg(session: Session) -> float:
    sigma_deg = math.degrees(session.setup.instruments.lambda_sigma_rad)
    return max(ADVISED_LAMBDA_DEG, math.ceil(sigma_deg * SAFE_BEND_SIGMAS))


def _check_part(
    session: Session, speed_m_s: Floats, least: int, part: str, unit: tuple[float, float]
) -> None:
    """Check readings and their speeds' span; unit: a speed's sigma and the belt's share in it."""
    names, pose = "ct and ft0", "straight (lambda_deg = 0)"
    if part == "bent":
        names, pose = "cn and fn0", f"with lambda_deg = {_advised_deg(session):g}"
    if len(speed_m_s) < least:
        raise BadInput(
            f"{session.where}: {names} cannot be told from {len(speed_m_s)} {part} reading(s); "
            f"they need at least {least}, {pose}, at belt speeds far apart (0.2 and 0.8 m/s, say); "
            "take more"
        )
    sigma_m_s, share = unit
    spread_m_s, needed = float(np.ptp(speed_m_s)), MIN_SPAN_SIGMAS * sigma_m_s
    if spread_m_s < needed:
        belt = (float(speed_m_s.min()) + 2.0 * needed) / (share or 1.0)
        raise BadInput(
            f"{session.where}: {names} cannot be told apart: the {part} readings' speeds along "
            f"their line span {spread_m_s:.3g} m/s, and must span at least four standard "
            f"deviations, {needed:.3g} m/s; a reading {pose} at another incline, with the belt "
            f"near {belt:.2g} m/s, would do it"
        )
