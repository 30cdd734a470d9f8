"""Bends in which a robot stays on course while it rolls, and what its joints do in them."""

from __future__ import annotations

from itertools import pairwise

from ..base.errors import BadInput

FEWEST_LINKS = 4  # links of a bend that balances itself
# Zigzag first: sessions of before there were others do not say.
BENDS = ("zigzag", "balanced")


def balanced_signs(links: int) -> tuple[int, ...]:
    """Return the sign of each link's angle in the balanced bend: 1, -1 or 0, from the tail.

    The signs read the same from both ends and add up to 0. Then the side forces of a robot that
    rolls along its axis have neither a sum nor a moment: a link's place is odd about the middle
    and its sign even. As many links as possible are bent, in pairs from either end; the middle
    stays straight.

    Parameters
    ----------
    links : how many links the robot has.

    Returns
    -------
    One sign a link, such as (1, -1, 0, 0, -1, 1) of six links.

    Raises
    ------
    BadInput
        Fewer than four links have no such bend.
    """
    if links < FEWEST_LINKS:
        raise BadInput(
            f"{links} links have no bend that balances itself, at least {FEWEST_LINKS} do: guide "
            "the robot on the belt and bend it as a zigzag"
        )
    half = [-1 if (k + 1) & 2 else 1 for k in range(2 * (links // 4))]
    return (*half, *[0] * (links - 2 * len(half)), *reversed(half))


def bend_signs(bend: str, links: int) -> tuple[int, ...]:
    """Return the sign of each link's angle in a bend, "balanced" or "zigzag", from the tail."""
    if bend == "balanced":
        return balanced_signs(links)
    return tuple(1 if link % 2 else -1 for link in range(links))


def joint_multiples(signs: tuple[int, ...]) -> tuple[int, ...]:
    """Return what each joint does, from the tail, as multiples of the links' angle."""
    return tuple(head - tail for tail, head in pairwise(signs))
