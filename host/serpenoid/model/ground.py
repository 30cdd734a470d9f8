"""Friction of the ground on a link: viscous and dry, along and across, forwards and backwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.checks import NOT_NEGATIVE, check_fields, check_number
from ..base.errors import BadInput
from .robot import check_links

Friction = float | tuple[float, float]  # one value, or (forwards, backwards)


@dataclass(frozen=True, slots=True)
class Ground:
    """The friction on the centre of one link, along it (t) and across it (n).

    The force opposes the motion: f^t = -(ct v^t + ft0 sgn v^t), and f^n likewise. sgn(0) is the
    interval [-1, 1], so that wheels stick. These are Eqs. 28-29, and Eqs. 59 and 62 over the number
    of links.

    Attributes
    ----------
    ct
        Viscous friction per link along it, N s/m, at least 0.
    cn
        Viscous friction per link across it, N s/m, at least 0.
    ft0
        Dry friction per link along it, N, at least 0.
    fn0
        Dry friction per link across it, N, at least 0.

    Raises
    ------
    BadInput
        If a value is negative or not finite.

    Notes
    -----
    For ratchet wheels ct and ft0 may each be a pair (forwards, backwards), for v^t > 0 (towards the
    head) and v^t < 0. At rest the ground then holds with any force from -ft0[0] to +ft0[1]. A pair
    of equal values becomes a single value. Wheels that cannot roll back have a large second value.

    Examples
    --------
    >>> ground = sn.Ground(ct=0.1, cn=10.0)  # of each link
    >>> whole = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> round(whole.ct, 4)
    0.014
    """

    ct: Friction
    cn: float
    ft0: Friction = 0.0
    fn0: float = 0.0

    def __post_init__(self) -> None:
        for name in ("ct", "ft0"):
            object.__setattr__(self, name, _check_friction(name, getattr(self, name)))
        check_fields(self, {"cn": NOT_NEGATIVE, "fn0": NOT_NEGATIVE})

    @classmethod
    def whole_body(
        cls, links: int, ct: Friction, cn: float, ft0: Friction = 0.0, fn0: float = 0.0
    ) -> Ground:
        """Return the ground on one link from the whole snake's ct, cn (N s/m), ft0 and fn0 (N)."""
        share = 1.0 / check_links(links)
        return cls(ct, cn, ft0, fn0).scaled(*4 * [share])

    @property
    def ct_forward(self) -> float:
        """Return ct towards the head, N s/m."""
        return _ways(self.ct)[0]

    @property
    def ct_backward(self) -> float:
        """Return ct towards the tail, N s/m."""
        return _ways(self.ct)[1]

    @property
    def ft0_forward(self) -> float:
        """Return ft0 towards the head, N."""
        return _ways(self.ft0)[0]

    @property
    def ft0_backward(self) -> float:
        """Return ft0 towards the tail, N."""
        return _ways(self.ft0)[1]

    def scaled(
        self, ct: float = 1.0, cn: float = 1.0, ft0: float = 1.0, fn0: float = 1.0
    ) -> Ground:
        """Return the ground with each friction times a factor, the same for both directions."""
        along = self.ct_forward * ct, self.ct_backward * ct
        dry_along = self.ft0_forward * ft0, self.ft0_backward * ft0
        return Ground(along, self.cn * cn, dry_along, self.fn0 * fn0)

    @property
    def dry(self) -> bool:
        """Return whether there is friction at rest (Coulomb or Bingham)."""
        return max(self.ft0_forward, self.ft0_backward, self.fn0) > 0.0

    @property
    def ratchet(self) -> bool:
        """Return whether friction forwards differs from friction backwards."""
        return isinstance(self.ct, tuple) or isinstance(self.ft0, tuple)

    @property
    def smooth(self) -> bool:
        """Return whether friction is smooth in the speed: viscous, the same in both directions."""
        return not self.dry and not self.ratchet


def _check_friction(name: str, value: object) -> Friction:
    """Return a friction as one number, or two that differ; raises BadInput."""
    if not isinstance(value, (Sequence, np.ndarray)) or np.ndim(value) == 0:
        return check_number(name, value, 0.0)
    ways = "forwards", "backwards"
    if len(value) != len(ways):
        raise BadInput(f"{name} is {value!r}; it must be one number, or two: forwards, backwards")
    forward, backward = (
        check_number(f"{name} {way}", number, 0.0) for way, number in zip(ways, value, strict=True)
    )
    return forward if forward == backward else (forward, backward)


def _ways(friction: Friction) -> tuple[float, float]:
    """Return a friction as a pair: forwards, backwards."""
    return friction if isinstance(friction, tuple) else (friction, friction)
