"""Camera, lens and tag mountings, fitted together with the chain in each of some frames.

Least squares of the corners' pixels; the states of single frames are eliminated (Schur), so that
a step costs little whatever the number of frames. Neighbouring links meet at their joint because
the states know nothing else; the link length is the scale.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..seeing.sightings import Sightings
from .camera import LENS, Camera

OUTLIER = 3.0  # Residual of a tag, in sigmas, from which its weight falls.
# Weight that keeps a frame's own state, else free, from running away where no tag holds it.
LOOSE_PER_RAD = 1.0 / np.radians(30.0)


@dataclass(frozen=True)
class Bundle:
    """What the fit found.

    camera; covariance of its shared unknowns, from the scatter of the frames; noise_px: standard
    deviation of a corner; side_m: the printed side of a tag; turns (links,): how tags are turned on
    their links, in whole quarter turns, rad; cost: of the fit.
    """

    camera: Camera
    covariance: Array
    noise_px: float
    side_m: float
    turns: Array
    cost: float

    @property
    def scale_off(self) -> float:
        """Return how far links and tags disagree, relative: then all lengths may be as far off.

        0 for what comes of tags put on askew, and for two links, of which none has two joints that
        tell its length.
        """
        excess, askew, pair = abs(self.camera.side_m / self.side_m - 1.0), 0.025, 2
        return excess if excess > askew and self.camera.links > pair else 0.0


def fit(
    camera: Camera,
    states: Array,
    sightings: Sightings,
    side_m: float,
    turns: Array,
    steps: int = 40,
    rough: bool = False,
) -> Bundle:
    """Fit camera and states to the sightings.

    rough: with a plain lens and a fixed noise, so that costs of several starts can be compared.
    """
    # Means and sigmas before any film: focal length (log), k1, k2, principal point (of the longer
    # side), tilts, distance (log), the tag's printed side (log; a rule is held against the sheet),
    # readout (s); and of each tag that a person puts on: place m, turn rad, height m, slopes.
    lens_mean = [np.log(0.9), 0, 0, 0, 0, *camera.shared[5:8], np.log(side_m), 0.012]
    lens_sigma = [0.5, 0.1, 0.04, 0.01, 0.01, 10.0, 10.0, 10.0, 0.01, 0.012]
    mounting_sigma = [0.005, 0.005, np.radians(2.0), 0.002, 0.03, 0.03]
    mean = replace(camera, shared=np.append(lens_mean, np.zeros(6 * camera.links)))
    prior_mean = mean.with_turns(turns).shared
    sigma = np.append(lens_sigma, mounting_sigma * camera.links)
    if rough:
        sigma[1:5] *= 0.05  # distortion and principal point
    point = _Point(sightings, states, prior_mean, sigma, camera, states, noise_px=0.3)
    damping, cost = 1e-3, point.cost()
    settled_damping, lost_damping = 1e-6, 1e6
    for _ in range(steps):
        trial = point.moved(damping)
        new_cost = trial.cost()
        if new_cost < cost:
            gained = cost - new_cost
            damping = max(damping / 5, 1e-9)
            point = trial if rough else replace(trial, noise_px=trial.noise())
            cost = point.cost()
            if gained < 1e-5 * new_cost and damping < settled_damping:
                break
        else:
            damping *= 8
            if damping > lost_damping:
                break
    return Bundle(point.camera, point.covariance(), point.noise_px, side_m, turns, cost)


def misses(camera: Camera, states: Array, s: Sightings) -> Array:
    """Return found less expected pixels (frames, links, 4, 2), 0 where nothing was found."""
    image = camera.image(camera.corners(states)) + camera.readout_s * s.skew
    return np.where(s.visible[..., None, None], s.corners_px - image, 0.0)


def rms(misses_px: Array) -> Array:
    """Return the root mean square of each tag's misses, (frames, links), px."""
    return np.sqrt(np.mean(misses_px**2, axis=(2, 3)))


def equations(
    camera: Camera, states: Array, s: Sightings, noise_px: float, shared: bool = False
) -> tuple[Array, Array]:
    """Return derivatives by the states, and misses, with each tag's weight.

    Each (frames, 8 links, unknowns), the misses (frames, 8 links, 1); before them stand the
    derivatives by what is shared, if asked for. The weight is 1, less for outliers, 0 for none.
    """
    residual = misses(camera, states, s)
    share = np.minimum(1.0, OUTLIER / np.maximum(rms(residual) / noise_px, 1e-9))
    root = (np.sqrt(s.visible * share) / noise_px)[..., None, None, None]
    columns = residual[..., None]
    if shared:
        by_shared = camera.by_shared(states)
        by_shared[..., len(LENS) - 1] = s.skew
        columns = np.concatenate([by_shared, columns], axis=-1)
    # A tag that was not found may be expected behind the camera, at NaN.
    a, b = (np.where(root > 0, part * root, 0.0) for part in (camera.by_states(states), columns))
    shape = len(states), 8 * s.links, -1
    return a.reshape(shape), b.reshape(shape)


@dataclass(frozen=True)
class _Point:
    """Hold sightings, priors, and the unknowns of a moment of the fit.

    start: states that the fit began with, to which frames are loosely held.
    """

    sightings: Sightings
    start: Array
    prior_mean: Array
    sigma: Array
    camera: Camera
    states: Array
    noise_px: float

    def noise(self) -> float:
        """Return the standard deviation of a corner's coordinate, px, robustly."""
        s = self.sightings
        residual = misses(self.camera, self.states, s)[s.visible]
        # Of 8 numbers a tag, some 3 go into its frame's state.
        return max(0.02, 1.4826 * float(np.median(np.abs(residual))) * np.sqrt(8 / 6.5))

    def _from_prior(self) -> tuple[Array, Array]:
        drift = (self.states - self.start) * LOOSE_PER_RAD
        drift[:, :2] = 0.0
        return (self.camera.shared - self.prior_mean) / self.sigma, drift

    def cost(self) -> float:
        """Return the sum of squares; an outlier's grows no faster than its distance."""
        distance = rms(misses(self.camera, self.states, self.sightings)) / self.noise_px
        if not np.isfinite(distance).all():
            return np.inf
        squares = np.where(distance < OUTLIER, distance**2, OUTLIER * (2 * distance - OUTLIER))
        priors = (np.sum(residual**2) for residual in self._from_prior())
        return 8 * float(squares.sum()) + float(sum(priors))

    def _normal(self, damping: float = 0.0) -> tuple[Array, Array, Array]:
        """Return the normal equations of the shared unknowns: matrix, scores, the frames' part.

        The matrix has the priors, each frame's score has not. damping holds the frames' states.
        """
        a, targets = equations(self.camera, self.states, self.sightings, self.noise_px, shared=True)
        unit = np.eye(a.shape[-1])
        of_frames = a.transpose(0, 2, 1) @ a
        of_frames[:, 2:, 2:] += LOOSE_PER_RAD**2 * unit[2:, 2:]
        of_frames += (1e-9 + damping * np.einsum("fii->fi", of_frames)[:, None]) * unit
        cross = a.transpose(0, 2, 1) @ targets
        cross[..., -1] -= LOOSE_PER_RAD * self._from_prior()[1]
        frame_steps = np.linalg.solve(of_frames, cross)
        reduced = (
            targets[..., :-1].transpose(0, 2, 1) @ targets
            - cross[..., :-1].transpose(0, 2, 1) @ frame_steps
        )
        matrix = reduced[..., :-1].sum(axis=0) + np.diag(1 / self.sigma**2)
        return matrix, reduced[..., -1], frame_steps

    def moved(self, damping: float) -> _Point:
        """Return the point after one damped step."""
        matrix, score, frame_steps = self._normal(damping)
        damped = matrix + damping * np.diag(np.diag(matrix))
        step = np.linalg.solve(damped, score.sum(axis=0) - self._from_prior()[0] / self.sigma)
        return replace(
            self,
            camera=replace(self.camera, shared=self.camera.shared + step),
            states=self.states + (frame_steps[..., -1] - frame_steps[..., :-1] @ step),
        )

    def covariance(self) -> Array:
        """Return the covariance from how the frames' scores scatter, and from the priors."""
        matrix, score, _ = self._normal()
        inverse = np.linalg.inv(matrix)
        frames = len(score)
        centred = score - score.mean(axis=0)
        # The frames' scatter counts twice: errors of edges follow the tags' angle and place, so
        # that frames are not independent (found by films of known truth).
        scatter = 2.0 * centred.T @ centred * frames / (frames - 1)
        return inverse @ (scatter + np.diag(1 / self.sigma**2)) @ inverse
