"""The posterior of all friction readings of a session, and its mode."""

from __future__ import annotations

import numpy as np

from ..session.session import Session
from .fitting.posterior import Mode, Posterior
from .fitting.shared import shared_covariance
from .fitting.stations import Stations
from .fitting.unknowns import Floats
from .floor.block import floor_blocks

USUAL, USUAL_N = (0.084, 1.2, 0.14, 0.27), 4.4484  # of the 2005 robot, and its weight


def posterior_of(session: Session) -> Posterior:
    """Return the posterior of a session's kept stations and pushes."""
    stations = (Stations.of(session),) if session.kept else ()
    return Posterior((*stations, *floor_blocks(session)))


def usual_frictions(session: Session) -> Floats:
    """Return the 2005 robot's frictions for a robot of this weight."""
    return np.array(USUAL) * session.setup.weight_n / USUAL_N


def scale_sigmas(session: Session, posterior: Posterior) -> tuple[float, float]:
    """Return the relative errors of belt and mass that are no unknowns (`fitting.shared`)."""
    belt = session.belt_scale[1] if session.kept and "belt" not in posterior.names else 0.0
    return belt, session.mass_sigma


def mode_of(session: Session) -> Mode:
    """Return the likeliest values that a session's readings leave. Raises NotConverged.

    They are sought from usual frictions.
    """
    posterior = posterior_of(session)
    return posterior.mode(posterior.start(usual_frictions(session)))


def covariance_after(session: Session, mode: Mode) -> Floats:
    """Return the frictions' covariance (P, P) that a session's readings leave, by their slopes.

    Belt and mass are in it. mode: where, of all or some of the readings; unknowns that it does not
    have are as before them.
    """
    posterior = posterior_of(session)
    x = np.array([mode.values.get(name, np.zeros(1))[0] for name in posterior.names])
    there, of = posterior.near(x).at(x), posterior.frictions
    return there.covariance[:of, :of] + shared_covariance(x[:of], *scale_sigmas(session, posterior))
