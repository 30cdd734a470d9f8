"""The slow, obvious truth: rigid chains on moving, tilted ground, forces summed wheel by wheel.

Plain NumPy, robots side by side, classical Runge-Kutta. Dry friction is F0 v / sqrt(v^2 + w^2).
Wheels that slide have an error of the first order in the width w, so that two widths tell the
limit. (Wheels that grip creep by far more: no truth for them.)
"""

from __future__ import annotations

import numpy as np

G = 9.81


class RigidChain:
    """N robots (N, n): link angles to link 1, held. ground: ct, cn, ft0, fn0 of a link.

    width: m/s, (N, 1).
    """

    def __init__(self, angle, mass, length, ground, width):
        a = np.atleast_2d(np.asarray(angle, dtype=float))
        half = length / 2 * np.stack([np.cos(a), np.sin(a)])
        centre = np.cumsum(half, axis=2) * 2 - half  # each centre half a link on from the joint
        self.r = centre - centre.mean(axis=2, keepdims=True)
        self.angle, self.mass, self.ground, self.width = a, mass, ground, width
        self.n = a.shape[1]
        self.J = self.n * mass * length**2 / 12 + mass * (self.r**2).sum(axis=(0, 2))

    def rate(self, y, belt, gamma):
        """y: (6, N) x, y, theta, vx, vy, w. x is downhill; the ground moves at -belt along x."""
        theta, vx, vy, w = y[2], y[3], y[4], y[5]
        c, s = np.cos(theta)[:, None], np.sin(theta)[:, None]
        rx, ry = c * self.r[0] - s * self.r[1], s * self.r[0] + c * self.r[1]
        ux = vx[:, None] - w[:, None] * ry + belt
        uy = vy[:, None] + w[:, None] * rx
        a = theta[:, None] + self.angle
        t, n = np.cos(a) * ux + np.sin(a) * uy, -np.sin(a) * ux + np.cos(a) * uy
        ct, cn, ft0, fn0 = self.ground
        ft = -ct * t - ft0 * t / np.sqrt(t * t + self.width**2)
        fn = -cn * n - fn0 * n / np.sqrt(n * n + self.width**2)
        fx, fy = np.cos(a) * ft - np.sin(a) * fn, np.sin(a) * ft + np.cos(a) * fn
        torque = (rx * fy - ry * fx).sum(axis=1)
        whole = self.n * self.mass
        return np.stack(
            [
                vx,
                vy,
                w,
                fx.sum(axis=1) / whole + G * np.sin(gamma),
                fy.sum(axis=1) / whole,
                torque / self.J,
            ]
        )

    def run(self, y, duration, dt, belt=0.0, gamma=0.0):
        for _ in range(round(duration / dt)):
            k1 = self.rate(y, belt, gamma)
            k2 = self.rate(y + dt / 2 * k1, belt, gamma)
            k3 = self.rate(y + dt / 2 * k2, belt, gamma)
            k4 = self.rate(y + dt * k3, belt, gamma)
            y = y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return y

    def at_rest(self):
        """In the room, the mean link along x."""
        y = np.zeros((6, self.angle.shape[0]))
        y[2] = -self.angle.mean(axis=1)
        return y
