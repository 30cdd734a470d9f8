"""What every single reading does to the fit: leave-one-out, by one linear step and no new fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .data import Floats
from .joint import Minimum

# A reading whose residual is its own to this share cannot be judged: nothing contradicts it.
_ALONE = 1.0 - 1e-9


BOTH_WAYS = ("ct", "cn", "ft0", "fn0", "ct_back", "ft0_back")  # in the order of the unknowns


@dataclass(frozen=True)
class LeaveOneOut:
    """Per reading: leverage, residual in its own sigmas, chi2 and shift of the unknowns without it.

    A reading that the others do not check at all (leverage 1) has residual 0 and no shift.
    """

    leverage: Floats
    studentised: Floats
    chi2: Floats
    shift: Floats


def leave_one_out(found: Minimum, count: int, share: Floats | float = 1.0) -> LeaveOneOut:
    """Return the influence of the first `count` rows, to first order about the minimum.

    share: of a row's variance in the reading's, where rounding is shared (`whole_residuals`).
    """
    covariance = np.linalg.inv(found.information)
    slopes, r = found.jacobian[:count], found.residuals[:count]
    gain = slopes @ covariance
    leverage = np.einsum("ij,ij->i", gain, slopes)
    checked = leverage < _ALONE
    rest = np.where(checked, 1.0 - leverage, 1.0)
    r = np.where(checked, r, 0.0)
    return LeaveOneOut(
        leverage=np.clip(1.0 - (1.0 - leverage) / share, 0.0, 1.0),
        studentised=r / np.sqrt(rest),
        chi2=found.chi2 - r**2 / rest,
        shift=gain * (r / rest)[:, None],
    )


@dataclass(frozen=True, slots=True)
class Influence:
    """What one reading does to a fit: how the parameters would move without it.

    reading: its number. leverage: 0 (the others say it as well) to 1 (nothing checks it).
    studentised: residual over its own standard deviation. shift: change of ct, cn, ft0, fn0 (and
    ct, ft0 backwards), if it were left out, in standard deviations of each. chi2_without: chi2 of
    the fit without it.
    """

    reading: int
    leverage: float
    studentised: float
    shift: tuple[float, ...]
    chi2_without: float

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name."""
        shift = dict(zip(BOTH_WAYS, self.shift, strict=False))
        return {
            "reading": self.reading,
            "leverage": self.leverage,
            "studentised": self.studentised,
            "shift_in_sigmas": shift,
            "chi2_without": self.chi2_without,
        }


def influences(found: Minimum, numbers: list[int], share: Floats) -> tuple[Influence, ...]:
    """Return what each reading does, in the readings' order."""
    out = leave_one_out(found, len(numbers), share)
    sigma = np.sqrt(np.diag(np.linalg.inv(found.information)))[: found.parameters]
    shift = (out.shift[:, : found.parameters] / sigma).tolist()
    columns = (out.leverage.tolist(), out.studentised.tolist(), shift, out.chi2.tolist())
    return tuple(
        Influence(number, h, t, tuple(s), chi2)
        for number, h, t, s, chi2 in zip(numbers, *columns, strict=True)
    )
