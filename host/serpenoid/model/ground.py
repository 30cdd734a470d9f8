"""Friction of the ground on every link: viscous, dry, along and across."""

from __future__ import annotations

from dataclasses import dataclass

from .checks import check_number
from .robot import check_links


@dataclass(frozen=True, slots=True)
class Ground:
    """Describe the friction on the centre of one link, along it (t) and across it (n).

    The force opposes the motion: f^t = -(ct v^t + ft0 sgn v^t), f^n likewise, with sgn(0) the
    whole interval [-1, 1] (wheels stick). ct, cn in N s/m (Eqs. 28-29); ft0, fn0 in N (Bingham,
    Eqs. 59 and 62 divided by n). All per link, none negative. Raises BadInput.
    """

    ct: float
    cn: float
    ft0: float = 0.0
    fn0: float = 0.0

    def __post_init__(self) -> None:
        for name in ("ct", "cn", "ft0", "fn0"):
            object.__setattr__(self, name, check_number(name, getattr(self, name), 0.0))

    @classmethod
    def whole_body(
        cls, links: int, ct: float, cn: float, ft0: float = 0.0, fn0: float = 0.0
    ) -> Ground:
        """Divide friction measured on the whole snake evenly among its links."""
        n = check_links(links)
        total = cls(ct, cn, ft0, fn0)
        return cls(total.ct / n, total.cn / n, total.ft0 / n, total.fn0 / n)

    @property
    def dry(self) -> bool:
        """Tell whether there is a friction force at rest (Coulomb or Bingham)."""
        return self.ft0 > 0.0 or self.fn0 > 0.0
