"""Links whose tags are missing: where the gait says that they point.

A joint that was seen for part of the film follows its own sine. Joints that were never seen follow
one travelling sine, whose amplitude and lag are those that explain how head and tail move beside
each other: the turn between them, and the vector from one to the other.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ..base.errors import BadInput
from ..base.sines import basis
from .arrays import Array
from .fitting.camera import Camera
from .fitting.start import tag_poses
from .motion import first_rate
from .seeing.sightings import Sightings

KNOWN_RAD = np.radians(2.0)  # how well a gait says where a link points
AMPLITUDES = np.radians([20.0, 40.0, 60.0])  # from which the fit starts
LAGS = np.radians(np.arange(-150, 180, 30))
OFTEN, TOGETHER = 0.3, 10  # share of the frames; frames with both ends
FITTED_FRAMES = 600  # at most, spread over the film


def outermost(sightings: Sightings) -> tuple[int, int]:
    """Return the first and the last link whose tag is seen often; 0, 0 for none."""
    often = np.flatnonzero(sightings.seen.mean(axis=0) > OFTEN)
    return (int(often[0]), int(often[-1])) if len(often) else (0, 0)


def travelling_sine(camera: Camera, sightings: Sightings, turns: Array) -> Array:
    """Return joints phi (frames, joints) of one sine that explains the outermost tags' motion.

    Unknown: amplitude, lag, phase, offset, and the scale of the picture. Raises BadInput where
    hardly a frame shows two tags.
    """
    from scipy.optimize import least_squares

    first, last = outermost(sightings)
    both = sightings.seen[:, first] & sightings.seen[:, last]
    if first == last or both.sum() < TOGETHER:
        raise BadInput("no tag is seen with another one: at least two must be seen together")
    centres, headings = tag_poses(camera, sightings)
    theta = headings - turns
    t = sightings.t_s - sightings.t_s.mean()
    apart = np.unwrap(theta[both, last] - theta[both, first])
    apart -= 2 * np.pi * np.round(apart.mean() / (2 * np.pi))
    gone = centres[both, last] - centres[both, first]
    gone = (gone[:, 0] + 1j * gone[:, 1]) * np.exp(-1j * theta[both, first]) / camera.link_m
    omega = first_rate(t[both], apart[:, None], np.ones((len(apart), 1)))
    few = slice(None, None, 1 + len(apart) // FITTED_FRAMES)
    times, apart, gone, inside = t[both][few], apart[few], gone[few], np.arange(last - first)

    def miss(x: Array) -> Array:
        """Return what amplitude, lag, phase, offset and rate leave of the turn and the vector."""
        phi = x[3] + x[0] * np.sin(x[4] * times[:, None] + x[2] + x[1] * inside)
        turned = np.concatenate([np.zeros((len(times), 1)), np.cumsum(phi, axis=1)], axis=1)
        unit = np.exp(1j * turned)
        way = 0.5 * unit[:, 0] + unit[:, 1:-1].sum(axis=1) + 0.5 * unit[:, -1]
        # The picture's scale is free: the vector counts by its best factor.
        factor = np.sum((way.conj() * gone).real) / np.sum(np.abs(way) ** 2)
        off = gone - factor * way
        return np.concatenate([turned[:, -1] - apart, off.real, off.imag])

    _, c, s = np.linalg.lstsq(basis(times, omega, 1), apart, rcond=None)[0]
    tried = []
    for amplitude, lag in product(AMPLITUDES, LAGS):
        sum_phase = np.angle(np.exp(1j * lag * inside).sum())
        x0 = np.array([amplitude, lag, np.arctan2(c, s) - sum_phase, 0.0, omega])
        tried.append(least_squares(miss, x0, max_nfev=30))
    a, lag, phase, offset, omega = min(tried, key=lambda solved: solved.cost).x
    joints = np.arange(sightings.links - 1) - first
    return offset + a * np.sin(omega * t[:, None] + phase + lag * joints)
