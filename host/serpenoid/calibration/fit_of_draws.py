"""A friction fit from a posterior's mode and its draws."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ..session.session import Session
from .fitting.posterior import Draws, Mode
from .fitting.shared import FRICTIONS, scaled
from .fitting.stations import Stations
from .fitting.suspects import influences
from .fitting.unknowns import Floats
from .friction_result import LEVEL, Estimate, FitDraws, FrictionFit, narrowest, with_values
from .session_posterior import scale_sigmas

DRAWS = 1024  # kept with a fit


def fit_of_draws(session: Session, mode: Mode, draws: Draws) -> FrictionFit:
    """Return the fit whose values are the mode's, intervals and covariance the draws'."""
    posterior, count = mode.posterior, mode.posterior.frictions
    x = scaled(draws.x[:, :count], *scale_sigmas(session, posterior))
    draws, weight = replace(draws, x=np.column_stack([x, draws.x[:, count:]])), draws.weight
    ends = [narrowest(x[:, k], draws.weight_for(k), mode.x[k]) for k in range(count)]
    covariance = np.cov(x.T, aweights=draws.boundless, ddof=0)
    covariance = _beside_limits(covariance, mode.x[:count], np.array(ends))
    nuisances, drawn = posterior.nuisances(mode.values), posterior.nuisances(draws.values)
    spread = {n: float(np.sqrt(np.cov(part, aweights=weight, ddof=0))) for n, part in drawn.items()}
    alike = draws.alike(DRAWS)
    rows = posterior.residuals(mode.x[None])[0]
    numbers = posterior.numbers
    readings = list(dict.fromkeys(numbers[numbers >= 0].tolist()))
    shown, sign, alone = _shown(mode, rows, readings)
    return with_values(
        session,
        mode.x[:count],
        covariance,
        np.array(ends),
        chi2=float(np.sum(rows**2)),
        dof=posterior.rows - count,
        nuisances=MappingProxyType(
            {name: Estimate(float(part[0]), spread[name]) for name, part in nuisances.items()}
        ),
        residuals=tuple(shown.tolist()),
        influence=influences(mode, sign, alone, np.sqrt(np.diag(covariance))),
        draws=FitDraws(FRICTIONS, alike.x[:, :count]),
    )


def _beside_limits(covariance: Floats, values: Floats, ends: Floats) -> Floats:
    """Return a covariance that agrees with intervals which end at the limit of 0.

    It is that of frictions which could be negative; the interval knows better.
    """
    from scipy.special import ndtri

    sigma = np.sqrt(np.diag(covariance))
    above = (ends[:, 1] - values) / float(ndtri(0.5 + LEVEL / 2))
    share = np.where(ends[:, 0] > 0.0, 1.0, np.minimum(above / np.maximum(sigma, 1e-300), 1.0))
    return covariance * np.outer(share, share)


def _shown(mode: Mode, rows: Floats, readings: list[int]) -> tuple[Floats, Floats, Floats]:
    """Return each reading's residual, its sign, and the share of its variance that it has alone.

    Of a push + where it rolled farther, or took less time, than the law.
    """
    shown, alone, stations = np.zeros(len(readings)), np.ones(len(readings)), 0
    for block in mode.posterior.blocks:
        if isinstance(block, Stations):
            stations = len(block)
            shown[:stations], alone[:stations] = (p[0] for p in block.whole_residuals(mode.values))
    dry = [k for k, name in enumerate(mode.posterior.names) if name.startswith("ft0")]
    for k, number in enumerate(readings[stations:], stations):
        mine = mode.posterior.numbers == number
        ease = float(mode.slopes[mine][:, dry].sum(axis=1) @ rows[mine])
        shown[k] = np.copysign(np.sqrt(np.mean(rows[mine] ** 2)), ease)
    return shown, np.copysign(1.0, shown), alone
