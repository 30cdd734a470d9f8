"""Bundle adjustment: fit camera, lens and tag mountings together with the chain in some frames.

It is a least-squares fit to the corners in pixels. The states of single frames are eliminated by a
Schur complement, so that a step is fast for any number of frames. The states are angles of a chain
whose links meet at the joints, and the link length sets the scale.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from ..seeing.sightings import Sightings
from .camera import LENS, Camera

OUTLIER = 3.0  # Residual of a tag, in sigmas, above which its weight decreases.
# Weight of a frame's initial angles, so that angles which no tag shows are determined.
LOOSE_PER_RAD = 1.0 / np.radians(30.0)


@dataclass(frozen=True)
class Bundle:
    """The result of the bundle adjustment.

    camera: the fitted camera. covariance: of its shared parameters, from the scatter of the frames.
    noise_px: standard deviation of a corner's coordinate. side_m: printed side of a tag. turns:
    (links,), rotation of each tag on its link, a multiple of pi / 2, rad. cost: of the fit.
    """

    camera: Camera
    covariance: Array
    noise_px: float
    side_m: float
    turns: Array
    cost: float

    @property
    def scale_off(self) -> float:
        """Return the relative disagreement of links and tags, an uncertainty of all lengths.

        It is 0 up to 2.5 %, which tags laid crooked on their links can cause. It is 0 for two links
        too, because the length of a link shows only between two joints.
        """
        excess, max_crooked, pair = abs(self.camera.side_m / self.side_m - 1.0), 0.025, 2
        return excess if excess > max_crooked and self.camera.links > pair else 0.0


def fit(
    camera: Camera,
    states: Array,
    sightings: Sightings,
    side_m: float,
    turns: Array,
    steps: int = 40,
    rough: bool = False,
) -> Bundle:
    """Return the bundle adjustment of a camera and states (frames, links + 2) to sightings.

    side_m: printed side of a tag. turns: (links,), as of Bundle. steps: largest number of steps.
    rough: fit with an ideal lens and a fixed noise, so that the costs of several starts can be
    compared.
    """
    # Prior means and sigmas: log of the focal length, k1, k2, principal point (over the longer
    # side), tilts, log of the distance, log of a tag's side (checked with a ruler), readout time in
    # s; and for each tag, as a person lays it: position in m, rotation in rad, height in m, slopes.
    lens_mean = [np.log(0.9), 0, 0, 0, 0, *camera.shared[5:8], np.log(side_m), 0.012]
    lens_sigma = [0.5, 0.1, 0.04, 0.01, 0.01, 10.0, 10.0, 10.0, 0.01, 0.012]
    mounting_sigma = [0.005, 0.005, np.radians(2.0), 0.002, 0.03, 0.03]
    mean = replace(camera, shared=np.append(lens_mean, np.zeros(6 * camera.links)))
    prior_mean = mean.with_turns(turns).shared
    sigma = np.append(lens_sigma, mounting_sigma * camera.links)
    if rough:
        sigma[1:5] *= 0.05  # Distortion and principal point.
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


def corner_residuals(camera: Camera, states: Array, s: Sightings) -> Array:
    """Return found minus expected corners, px, (frames, links, 4, 2); 0 for tags not found."""
    image = camera.image(camera.corners(states)) + camera.readout_s * s.skew
    return np.where(s.visible[..., None, None], s.corners_px - image, 0.0)


def rms(misses_px: Array) -> Array:
    """Return the root mean square of each tag's residuals, (frames, links), px."""
    return np.sqrt(np.mean(misses_px**2, axis=(2, 3)))


def equations(
    camera: Camera, states: Array, s: Sightings, noise_px: float, shared: bool = False
) -> tuple[Array, Array]:
    """Return weighted derivatives by the states, and weighted residuals.

    The derivatives are (frames, 8 links, states) and the residuals (frames, 8 links, 1). shared:
    whether the derivatives by the shared parameters precede the residuals in the second array. The
    weight of a tag is 1, less for outliers, and 0 if it was not found.
    """
    residual = corner_residuals(camera, states, s)
    share = np.minimum(1.0, OUTLIER / np.maximum(rms(residual) / noise_px, 1e-9))
    root = (np.sqrt(s.visible * share) / noise_px)[..., None, None, None]
    columns = residual[..., None]
    if shared:
        by_shared = camera.by_shared(states)
        by_shared[..., len(LENS) - 1] = s.skew  # by the readout time
        columns = np.concatenate([by_shared, columns], axis=-1)
    # The expected corners of a tag that was not found may be behind the camera, at NaN.
    a, b = (np.where(root > 0, part * root, 0.0) for part in (camera.by_states(states), columns))
    shape = len(states), 8 * s.links, -1
    return a.reshape(shape), b.reshape(shape)


@dataclass(frozen=True)
class _Point:
    """Sightings, priors, and the present parameters of the fit.

    start: initial states, towards which frames are weakly regularised.
    """

    sightings: Sightings
    start: Array
    prior_mean: Array
    sigma: Array
    camera: Camera
    states: Array
    noise_px: float

    def noise(self) -> float:
        """Return a robust estimate of the standard deviation of a corner's coordinate, px."""
        s = self.sightings
        residual = corner_residuals(self.camera, self.states, s)[s.visible]
        # Of the 8 coordinates of a tag, some 1.5 are used up by the frame's state.
        return max(0.02, 1.4826 * float(np.median(np.abs(residual))) * np.sqrt(8 / 6.5))

    def _from_prior(self) -> tuple[Array, Array]:
        drift = (self.states - self.start) * LOOSE_PER_RAD
        drift[:, :2] = 0.0
        return (self.camera.shared - self.prior_mean) / self.sigma, drift

    def cost(self) -> float:
        """Return the sum of squares; the part of a tag beyond OUTLIER grows linearly (Huber)."""
        distance = rms(corner_residuals(self.camera, self.states, self.sightings)) / self.noise_px
        if not np.isfinite(distance).all():
            return np.inf
        squares = np.where(distance < OUTLIER, distance**2, OUTLIER * (2 * distance - OUTLIER))
        priors = (np.sum(residual**2) for residual in self._from_prior())
        return 8 * float(squares.sum()) + float(sum(priors))

    def _normal(self, damping: float = 0.0) -> tuple[Array, Array, Array]:
        """Return matrix and scores of the shared parameters, and the steps of the frames' states.

        The matrix contains the priors; the scores (frames, shared) do not. damping: factor of the
        diagonal that is added to the frames' matrices.
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
        """Return the covariance from the scatter of the frames' scores, and from the priors."""
        matrix, score, _ = self._normal()
        inverse = np.linalg.inv(matrix)
        frames = len(score)
        centred = score - score.mean(axis=0)
        # The scatter is doubled, because frames are not independent: errors of edges depend on the
        # tags' angle and position. The factor is from rendered films.
        scatter = 2.0 * centred.T @ centred * frames / (frames - 1)
        return inverse @ (scatter + np.diag(1 / self.sigma**2)) @ inverse
