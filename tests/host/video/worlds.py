"""Robots that crawl before the camera along known curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from video.filming import Body, Film, Lens, Pose, write

LINK_M, SIDE_M = 0.076, 0.034


@dataclass(frozen=True)
class World:
    """A pose at each time, and what is true of it."""

    pose: Pose
    links: int
    omega_rad_s: float
    amplitude_rad: np.ndarray
    phase_rad: np.ndarray
    offset_rad: np.ndarray
    speed_m_s: float
    turn_rad_s: float


def crawling(
    seed: int = 1,
    links: int = 6,
    speed_m_s: float = 0.05,
    alpha_deg: float = 45.0,
    omega_rad_s: float = 4.0,
    start_m: float = -0.11,
    wrong_way: int | None = None,
) -> World:
    """Return a robot whose joints, path and turn are known exactly; no joint is perfect.

    wrong_way: a joint whose servo turns so, from 0; the one before it is 3 degrees off its centre.
    """
    rng = np.random.default_rng(seed)
    joints = links - 1
    amplitude = np.radians(alpha_deg) * (1 + 0.03 * rng.normal(size=joints))
    phase = np.radians(80) * np.arange(joints) + 0.04 * rng.normal(size=joints)
    offset = np.radians(1.5) * rng.normal(size=joints)
    turn, way = np.radians(1.2), 0.15
    if wrong_way is not None:
        phase[wrong_way] += np.pi
        offset[wrong_way - 1] = np.radians(3)

    def pose(t: float) -> tuple[np.ndarray, np.ndarray]:
        phi = offset + amplitude * np.sin(omega_rad_s * t + phase)
        angle = np.concatenate([[0.0], np.cumsum(phi)])
        angle += way + turn * t + 0.08 * np.sin(omega_rad_s * t) - angle.mean()
        half = LINK_M / 2 * np.exp(1j * angle)
        centre = np.concatenate([[0.0], np.cumsum(half[:-1] + half[1:])])
        middle = start_m + speed_m_s * (np.exp(1j * turn * t) - 1) / (1j * turn)
        middle += 0.004 * np.sin(2 * omega_rad_s * t) * np.exp(1j * turn * t)
        centre += middle * np.exp(1j * way) - centre.mean()
        return np.column_stack([centre.real, centre.imag]), angle

    return World(pose, links, omega_rad_s, amplitude, phase, offset, speed_m_s, turn)


# Two periods of a small robot: quick to draw, and to measure.
QUICK = crawling(2, 4, omega_rad_s=8.0, alpha_deg=40, speed_m_s=0.08, start_m=-0.06)


def shoot(
    world: World,
    path,
    lens: Lens | None = None,
    body: Body | None = None,
    seconds: float = 3.6,
    rate_hz: float = 30.0,
    times_s: np.ndarray | None = None,
    crf: int = 20,
    **film,
):
    """Render a film of a world into a file, at a phone's varying times; return the path."""
    if times_s is None:
        rng = np.random.default_rng(1)
        times_s = np.arange(0, seconds, 1 / rate_hz)
        times_s = times_s + 0.03 / rate_hz * rng.normal(size=len(times_s))
    camera = Film(lens or Lens(), body or Body(world.links), world.pose, **film)
    return write(path, [camera.frame(t) for t in times_s], times_s - times_s[0], crf)


def errors(run, world: World) -> dict[str, np.ndarray]:
    """Return the errors of a run's numbers, and these over their sigmas, (2, ...) each."""
    rows = [(j.amplitude_rad, j.amplitude_sigma_rad, j.phase_rad) for j in run.joints]
    amplitude, amplitude_sigma, phase = np.array(rows).T
    late = np.exp(1j * (phase - world.phase_rad + world.phase_rad[0]))
    off = {
        "speed": (run.speed_m_s - world.speed_m_s, run.speed_sigma_m_s),
        "rate": (run.omega_rad_s - world.omega_rad_s, run.omega_sigma_rad_s),
        "turn": (run.turn_rad_s - world.turn_rad_s, run.turn_sigma_rad_s),
        "amplitude": (amplitude - world.amplitude_rad, amplitude_sigma),
        "phase": (np.angle(late)[1:], np.array([j.phase_sigma_rad for j in run.joints[1:]])),
    }
    return {name: np.array([error, error / sigma]) for name, (error, sigma) in off.items()}


def max_sigmas(off: dict[str, np.ndarray]) -> float:
    """Return the largest of all errors, in sigmas."""
    return max(float(np.abs(over).max()) for _, over in off.values())
