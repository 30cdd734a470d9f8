"""The one family of exceptions: its base, and what every room raises of bad input."""

from __future__ import annotations

MOST_SHOWN = 2000  # characters of a message: what came from outside may be a megabyte


def shortened(text: str) -> str:
    """Return a message without the middle if it is long: begin and way out stay."""
    half = MOST_SHOWN // 2
    return text if len(text) <= MOST_SHOWN else f"{text[:half]} [...] {text[-half:]}"


class SerpenoidError(Exception):
    """Base of every error raised on purpose: what happened, the value, the limits, the way out.

    Way out: in the message.

    Examples
    --------
    >>> try:
    ...     sn.Robot(links=1, link_mass_kg=0.1, link_length_m=0.1)
    ... except sn.SerpenoidError as error:
    ...     print(type(error).__name__)
    BadInput
    """

    def __str__(self) -> str:
        return shortened(super().__str__())


class BadInput(SerpenoidError, ValueError):
    """A parameter, a file or a state is outside what the models or the robot allow.

    Way out: the message names the value, the limits and, of a file, the line: change it there.

    Examples
    --------
    >>> sn.Ground(ct=-1.0, cn=10.0)
    Traceback (most recent call last):
    serpenoid.base.errors.BadInput: ct is -1.0; it must be a finite number, at least 0
    """
