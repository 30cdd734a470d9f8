"""Every method: what it runs, its order, where it picks steps."""

from __future__ import annotations

from dataclasses import dataclass

from ..model.words import DRIVES, FORMULATIONS, LAWS, RECORDS


@dataclass(frozen=True, slots=True)
class MethodKind:
    """Say which scenes a method runs.

    order: of convergence at recorded times, for smooth motion. adaptive: formulations in which it
    takes steps of its own to scene.tolerance; in the others steps of dt_s. records: what it can
    record besides the motion. plain: formulations in which it runs with drive "angle", with all
    joints sound, on the level unless plain_incline, and can record no more than plain_records.
    faults: whether it runs with limp or locked joints.
    """

    order: int
    formulations: tuple[str, ...] = FORMULATIONS
    adaptive: tuple[str, ...] = ()
    drives: tuple[str, ...] = DRIVES
    laws: tuple[str, ...] = LAWS
    records: tuple[str, ...] = RECORDS
    plain: tuple[str, ...] = ()
    plain_records: tuple[str, ...] = ()
    plain_incline: bool = False
    faults: bool = True


METHODS = {
    "rk4": MethodKind(4),
    "euler": MethodKind(1),
    "semi_implicit_euler": MethodKind(1),
    "paper": MethodKind(1, formulations=("implicit",)),
    "dop853": MethodKind(8, adaptive=FORMULATIONS, laws=("viscous", "smoothed")),
    "collocation": MethodKind(
        7,
        formulations=("explicit",),
        adaptive=("explicit",),
        drives=("angle",),
        laws=("viscous",),
        plain=("explicit",),
        plain_records=("joints", "friction"),
    ),
    "radau": MethodKind(
        5,
        formulations=("implicit",),
        adaptive=("implicit",),
        laws=("viscous", "smoothed"),
        faults=False,
    ),
    "nonsmooth": MethodKind(
        2,
        adaptive=("explicit",),
        laws=("viscous", "dry"),
        records=("joints", "friction"),
        plain=("explicit",),
        plain_records=("joints", "friction"),
        plain_incline=True,
    ),
}
