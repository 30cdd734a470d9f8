"""Every method of stepping a scene in time: what it runs, its order, where it picks its steps."""

from __future__ import annotations

from dataclasses import dataclass

FORMULATIONS = ("explicit", "implicit")
DRIVES = ("angle", "torque", "servo")
LAWS = ("viscous", "smoothed", "dry")


@dataclass(frozen=True, slots=True)
class MethodKind:
    """Say which scenes a method runs.

    order: of convergence, for smooth motion. adaptive: formulations in which it takes steps of its
    own to scene.tolerance; in the others steps of dt_s. plain: formulations in which it runs with
    drive "angle", on the level, with all joints sound, and records no forces.
    """

    order: int
    formulations: tuple[str, ...] = FORMULATIONS
    adaptive: tuple[str, ...] = ()
    drives: tuple[str, ...] = DRIVES
    laws: tuple[str, ...] = LAWS
    plain: tuple[str, ...] = ()


METHODS = {
    "rk4": MethodKind(4),
    "euler": MethodKind(1),
    "semi_implicit_euler": MethodKind(1),
    "paper": MethodKind(1, formulations=("implicit",)),
    "nonsmooth": MethodKind(
        1, adaptive=("explicit",), laws=("viscous", "dry"), plain=("explicit",)
    ),
}
