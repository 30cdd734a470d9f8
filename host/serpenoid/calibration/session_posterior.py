"""The posterior of all friction readings of a session, and where its mode is sought from."""

from __future__ import annotations

import numpy as np

from .fitting.paper_fit import two_lines
from .fitting.posterior import Mode, Posterior
from .fitting.shared import shared_covariance
from .fitting.stations import Stations
from .fitting.unknowns import Floats
from .floor.block import Pushes, Slides, floor_blocks
from .session import Session

_USUAL = (0.2, 1.0, 0.15, 0.3)  # ct, cn, ft0, fn0 where slides alone tell them


def posterior_of(session: Session) -> Posterior:
    """Return the posterior of a session's kept stations, pushes and slides."""
    stations = (Stations.of(session),) if session.kept else ()
    return Posterior((*stations, *floor_blocks(session)))


def start_of(posterior: Posterior) -> Floats:
    """Return a point to seek the mode from: two lines through stations, or how pushes brake."""
    whole = np.zeros(posterior.frictions)
    for block in reversed(posterior.blocks):
        if isinstance(block, Pushes):
            whole[:4] = block.rough_frictions()
        elif isinstance(block, Slides):
            whole[:4] = np.where(whole[:4] > 0.0, whole[:4], _USUAL)
        elif isinstance(block, Stations):
            least = min(block.parts[part].sum() for part in ("straight", "bent"))
            told = block.parameters if least > 1 else 0
            whole[:told] = np.abs(two_lines(block)[0])[:told] if told else whole[:told]
    whole[4:] = np.where(whole[4:] > 0.0, whole[4:], whole[[0, 2]][: len(whole) - 4])
    return posterior.start(whole)


def scale_sigmas(session: Session) -> tuple[float, float]:
    """Return the relative errors of belt and mass that no reading tells (`fitting.shared`).

    Of a belt's: where there are pushes beside the stations they tell it.
    """
    belt = session.belt_scale[1] if session.kept and not session.on_floor else 0.0
    return belt, session.mass_sigma


def mode_of(session: Session) -> Mode:
    """Return the likeliest values that a session's readings leave. Raises NotConverged."""
    posterior = posterior_of(session)
    return posterior.mode(start_of(posterior))


def covariance_after(session: Session, mode: Mode) -> Floats:
    """Return the frictions' covariance (P, P) that a session's readings leave, by their slopes.

    Belt and mass are in it. mode: where, of all or some of the readings; unknowns that it does not
    have are as before them.
    """
    posterior = posterior_of(session)
    x = np.array([mode.values.get(name, np.zeros(1))[0] for name in posterior.names])
    there, of = posterior.near(x).near(x).at(x), posterior.frictions
    return there.covariance[:of, :of] + shared_covariance(x[:of], *scale_sigmas(session))
