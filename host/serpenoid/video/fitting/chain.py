"""The chain of links in the plane of its tags: where link centres stand, and how that changes."""

from __future__ import annotations

from functools import cache

import numpy as np

from ..arrays import Array, Mask


@cache
def lever_matrix(links: int) -> Array:
    """Return M of c_i = c + L sum_j M_ij u_j, (links, links).

    c_i: centre of link i; c: mean of the centres; L: link length; u_j: unit vector along link j.
    Neighbouring links meet at their joint: c_{i+1} - c_i = L (u_i + u_{i+1}) / 2.
    """
    from_tail = np.tril(np.ones((links, links)), -1) + 0.5 * np.eye(links)
    from_tail[:, 0] -= 0.5  # the tail link's own half is not passed
    return from_tail - from_tail.mean(axis=0)


def link_centres(states: Array, link_m: float) -> Array:
    """Return the centres of the links, (..., links, 2).

    states: (..., links + 2): mean of the centres x, y (m), then headings theta_1..theta_n (rad).
    """
    theta = states[..., 2:]
    along = np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    levers = link_m * lever_matrix(theta.shape[-1])
    return states[..., None, :2] + levers @ along


def wrapped(angle: Array) -> Array:
    """Return angles within half a turn."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def joint_angles(states: Array) -> Array:
    """Return phi_i = theta_{i+1} - theta_i, (..., links - 1), within half a turn."""
    return wrapped(np.diff(states[..., 2:], axis=-1))


def mean_heading(states: Array) -> Array:
    """Return the mean of the links' headings over time, (frames,), without jumps of a turn.

    By the joints, which bend by less than half a turn: the heading of a link that no tag holds may
    be off by a whole one.
    """
    bend = np.cumsum(joint_angles(states), axis=-1).sum(axis=-1) / (states.shape[-1] - 2)
    return np.unwrap(states[..., 2] + bend)


def filled_headings(states: Array, visible: Mask, phi: Array) -> Array:
    """Return states whose unseen links point as the joints phi (frames, joints) say.

    From the nearest links that are seen (frames, links), on both sides; the nearer one counts for
    more.
    """
    filled, links = states.copy(), np.arange(visible.shape[1])
    bend = np.zeros(visible.shape)
    bend[:, 1:] = np.cumsum(np.broadcast_to(phi, (len(visible), len(links) - 1)), axis=1)
    for pattern in np.unique(visible, axis=0):
        if pattern.all() or not pattern.any():
            continue
        rows = (visible == pattern).all(axis=1)
        base = np.unwrap((states[rows, 2:] - bend[rows])[:, pattern], axis=1)
        shares = [
            np.interp(links[~pattern], links[pattern], unit) for unit in np.eye(pattern.sum())
        ]
        filled[np.ix_(rows, 2 + links[~pattern])] = base @ shares + bend[rows][:, ~pattern]
    return filled
