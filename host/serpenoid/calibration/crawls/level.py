"""A session's crawls as they would be on level ground, by the slope that its pushes told."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..friction_result import Estimate, FrictionFit
from ..kinds.video import FilmReading
from ..session import Session
from .data import CrawlData


def floor_slope(session: Session, fit: FrictionFit | None) -> Estimate:
    """Return the floor's slope, rad, as pushes told it, or as nobody knows it."""
    told = (
        []
        if fit is None
        else [value for name, value in fit.nuisances.items() if name.startswith("floor_slope_rad")]
    )
    return told[0] if told else Estimate(0.0, session.setup.floor.slope_sigma_rad)


def on_level(session: Session, fit: FrictionFit) -> Session:
    """Return the session with crawls that went there or back brought to level ground.

    What the slope does to a gait is simulated; its doubt is in the speeds' standard deviations. The
    session as it is, where no crawl went there or back.
    """
    seen = CrawlData.of(session)
    level = seen.on_slope(fit.robot, fit.ground, floor_slope(session, fit))
    if level is seen:
        return session
    factors = level.speed_m_s / seen.speed_m_s
    added = np.sqrt(np.maximum(level.sigma_m_s**2 - (factors * seen.sigma_m_s) ** 2, 0.0))
    by_number = {
        number: (factor, math.sqrt(len(numbers)) * off)
        for numbers, factor, off in zip(seen.numbers, factors.tolist(), added.tolist(), strict=True)
        for number in numbers
    }

    def brought(reading: Any) -> Any:
        factor, off = by_number.get(reading.number, (1.0, 0.0))
        sigma = math.hypot(factor * reading.speed_sigma_m_s, off)
        return replace(
            reading, speed_m_s=factor * reading.speed_m_s, speed_sigma_m_s=sigma, way="level"
        )

    return replace(
        session,
        gait_runs=tuple(map(brought, session.gait_runs)),
        further=tuple(brought(r) if isinstance(r, FilmReading) else r for r in session.further),
    )
