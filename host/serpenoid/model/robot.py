"""The robot of a study: a chain of equal rigid links."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ..base.checks import POSITIVE, check_fields, check_number, check_whole

MAX_LINKS = 100_000
MAX_DENSITY_KG_M3 = 22_600  # osmium, the densest metal: no link outweighs a cube of it


check_links = partial(check_whole, "links", low=2, high=MAX_LINKS)


def frame_us(joints: int) -> int:
    """Return the time from setpoint to setpoint of a board with so many joints, µs."""
    return max(20_000, 2_500 * (joints + 1))


@dataclass(frozen=True, slots=True)
class Robot:
    """Describe the body of a robot: equal rigid links; serpenoid.robot.Robot is a board to drive.

    Link 1 is the tail, link n the head.

    Attributes
    ----------
    links
        Number of links n, 2 or more.
    link_mass_kg
        Mass m of one link, kg.
    link_length_m
        Full length 2l of one link, joint to joint, m.
    link_inertia_kg_m2
        Moment of inertia I_c of one link about its centre, kg m^2; a uniform rod's m L^2 / 12
        unless given.

    Raises
    ------
    BadInput
        For values out of range.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> robot.links, round(robot.inertia_kg_m2, 8)
    (6, 3.639e-05)
    """

    links: int
    link_mass_kg: float
    link_length_m: float
    link_inertia_kg_m2: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", check_links(self.links))
        check_fields(self, {"link_mass_kg": POSITIVE, "link_length_m": POSITIVE})
        if self.link_inertia_kg_m2 is None:
            rod = self.link_mass_kg * self.link_length_m**2 / 12.0
            object.__setattr__(self, "link_inertia_kg_m2", rod)
        check_fields(self, {"link_inertia_kg_m2": POSITIVE})

    @classmethod
    def whole_body(
        cls,
        links: int,
        mass_kg: float,
        link_length_m: float,
        link_inertia_kg_m2: float | None = None,
    ) -> Robot:
        """Return a robot whose links share the whole robot's mass evenly.

        Parameters
        ----------
        links
            Number of links, 2 or more.
        mass_kg
            Mass of the whole robot, kg.
        link_length_m
            Length of one link, joint to joint, m.
        link_inertia_kg_m2
            Moment of inertia of one link about its centre, kg m^2; a uniform rod's unless given.

        Returns
        -------
        Robot
            The robot.

        Raises
        ------
        BadInput
            For values out of range.

        Examples
        --------
        >>> robot = sn.Robot.whole_body(links=6, mass_kg=0.4536, link_length_m=0.076)
        >>> round(robot.link_mass_kg, 4)
        0.0756
        """
        link_mass_kg = check_number("mass_kg", mass_kg, *POSITIVE) / check_links(links)
        return cls(links, link_mass_kg, link_length_m, link_inertia_kg_m2)

    @property
    def mass_kg(self) -> float:
        """Return the mass of the whole robot, kg."""
        return self.links * self.link_mass_kg

    @property
    def inertia_kg_m2(self) -> float:
        """Return the moment of inertia I_c of one link, kg m^2, given or not."""
        assert self.link_inertia_kg_m2 is not None  # set above
        return self.link_inertia_kg_m2

    @property
    def body_length_m(self) -> float:
        """Return the length of the straight chain, m."""
        return self.links * self.link_length_m
