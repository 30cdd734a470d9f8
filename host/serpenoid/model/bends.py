"""Link and joint angles of the bends in which a robot is pulled or pushed for calibration."""

from __future__ import annotations

from itertools import pairwise

from ..base.errors import BadInput

MIN_LINKS = 4  # Fewest links of a balanced bend.
BENDS = ("zigzag", "balanced")  # The first is the default of old sessions, which do not name it.


def balanced_signs(links: int) -> tuple[int, ...]:
    """Return the sign of each link's angle in the balanced bend, from the tail: 1, -1 or 0.

    The signs are symmetric about the middle and add up to 0. So the side forces on a robot that
    rolls along its axis have no sum, and, as the links' positions are antisymmetric, no moment. As
    many links as possible are bent, in pairs from either end; those in the middle stay straight.

    Parameters
    ----------
    links
        Number of links of the robot.

    Returns
    -------
    tuple of int
        A sign for each link, such as (1, -1, 0, 0, -1, 1) for six links.

    Raises
    ------
    BadInput
        If there are fewer than four links.
    """
    if links < MIN_LINKS:
        raise BadInput(
            f"{links} links have no balanced bend, which needs at least {MIN_LINKS}; bend the "
            "robot as a zigzag and guide it on the belt"
        )
    bent_half = links // 4 * 2
    half = ((1, -1, -1, 1) * links)[:bent_half]
    straight = (0,) * (links - 2 * bent_half)
    return half + straight + half[::-1]


def bend_signs(bend: str, links: int) -> tuple[int, ...]:
    """Return the sign of each link's angle in a bend of BENDS, from the tail: 1, -1 or 0."""
    if bend == "balanced":
        return balanced_signs(links)
    return tuple(1 if link % 2 else -1 for link in range(links))


def joint_multiples(signs: tuple[int, ...]) -> tuple[int, ...]:
    """Return each joint's angle over the links' angle, from the tail, given the links' signs."""
    return tuple(head - tail for tail, head in pairwise(signs))
