"""What a study is made of: Robot, Ground, Gait, as frozen values in SI units and radians."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .. import _core
from .errors import BadInput, check_number

MAX_LINKS = 100_000


def check_links(links: object) -> int:
    """Return links as an int, or raise BadInput."""
    if isinstance(links, bool) or not hasattr(links, "__index__"):
        raise BadInput(f"links is {links!r}; it must be a whole number from 2 to {MAX_LINKS}")
    n = links.__index__()  # type: ignore[attr-defined]
    if not 2 <= n <= MAX_LINKS:
        raise BadInput(f"links is {n}; it must be a whole number from 2 to {MAX_LINKS}")
    return n


@dataclass(frozen=True, slots=True)
class Robot:
    """Describe a chain of equal rigid links; link 1 is the tail, link n the head.

    links: number of links n, 2 or more. link_mass_kg: mass m of one link. link_length_m: full
    length 2l of one link, joint to joint. link_inertia_kg_m2: moment of inertia I_c of one link
    about its centre; a uniform rod's m L^2 / 12 unless given. Raises BadInput.
    """

    links: int
    link_mass_kg: float
    link_length_m: float
    link_inertia_kg_m2: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", check_links(self.links))
        for name in ("link_mass_kg", "link_length_m"):
            value = check_number(name, getattr(self, name), 0.0, open_low=True)
            object.__setattr__(self, name, value)
        inertia = self.link_inertia_kg_m2
        if inertia is None:
            inertia = self.link_mass_kg * self.link_length_m**2 / 12.0
        inertia = check_number("link_inertia_kg_m2", inertia, 0.0, open_low=True)
        object.__setattr__(self, "link_inertia_kg_m2", inertia)

    @property
    def inertia_kg_m2(self) -> float:
        """Return the moment of inertia I_c of one link, given or not."""
        assert self.link_inertia_kg_m2 is not None  # set above
        return self.link_inertia_kg_m2


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


@dataclass(frozen=True, slots=True)
class Gait:
    """Describe the joint angles phi_i(t) = offset + alpha sin(omega t + (i - 1) beta), Eq. 57.

    phi_i = theta_{i+1} - theta_i is the angle of joint i, i = 1..n-1 counted from the tail.
    alpha_rad: amplitude, 0..pi. beta_rad: phase lag from joint to joint. omega_rad_s: angular
    rate, above 0. offset_rad: constant bend of every joint, which steers. Raises BadInput.
    """

    alpha_rad: float
    beta_rad: float
    omega_rad_s: float
    offset_rad: float = 0.0

    def __post_init__(self) -> None:
        checked = {
            "alpha_rad": check_number("alpha_rad", self.alpha_rad, 0.0, math.pi),
            "beta_rad": check_number("beta_rad", self.beta_rad, -2 * math.pi, 2 * math.pi),
            "omega_rad_s": check_number("omega_rad_s", self.omega_rad_s, 0.0, open_low=True),
            "offset_rad": check_number("offset_rad", self.offset_rad, -math.pi, math.pi),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def period_s(self) -> float:
        """Return 2 pi / omega."""
        return 2 * math.pi / self.omega_rad_s


def core_model(robot: Robot, ground: Ground, gait: Gait) -> _core.Model:
    """Hand the three to the compiled core (which counts length by halves, as the paper does)."""
    return _core.Model(
        robot.links, robot.link_mass_kg, robot.link_length_m / 2, robot.inertia_kg_m2,
        ground.ct, ground.cn, ground.ft0, ground.fn0,
        gait.alpha_rad, gait.beta_rad, gait.omega_rad_s, gait.offset_rad,
    )  # fmt: skip
