"""Predict, drive and calibrate a wheeled snake robot; see the README for a first run."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .errors import BadInput, Diverged, NotConverged, SerpenoidError, StepTooLarge

if TYPE_CHECKING:
    from .drives import Servo, TorqueTable
    from .dynamics import Acceleration, AngleDrive, LinkState, TorqueDrive, acceleration
    from .friction import fit_friction
    from .friction_result import FrictionFit
    from .gaits import GaitRuns, simulate_gaits
    from .model import Gait, Ground, Robot
    from .optimize import LeastPower, least_power_gait
    from .scene import Scene
    from .scene_file import load_scene, save_scene
    from .session import Session, load_session
    from .simulation import Run, simulate
    from .springs import SteadySprings, steady_springs
    from .steady import Steady, Sweep, steady_gait, sweep

# Where the rest is, imported at first use: the command line answers --help without NumPy.
_HOMES = {
    "dynamics": ("Acceleration", "AngleDrive", "LinkState", "TorqueDrive", "acceleration"),
    "friction": ("fit_friction",),
    "friction_result": ("FrictionFit",),
    "gaits": ("GaitRuns", "simulate_gaits"),
    "model": ("Gait", "Ground", "Robot"),
    "optimize": ("LeastPower", "least_power_gait"),
    "drives": ("Servo", "TorqueTable"),
    "scene": ("Scene",),
    "scene_file": ("load_scene", "save_scene"),
    "session": ("Session", "load_session"),
    "simulation": ("Run", "simulate"),
    "springs": ("SteadySprings", "steady_springs"),
    "steady": ("Steady", "Sweep", "steady_gait", "sweep"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Acceleration",
    "AngleDrive",
    "BadInput",
    "Diverged",
    "FrictionFit",
    "Gait",
    "GaitRuns",
    "Ground",
    "LeastPower",
    "LinkState",
    "NotConverged",
    "Robot",
    "Run",
    "Scene",
    "SerpenoidError",
    "Servo",
    "Session",
    "Steady",
    "SteadySprings",
    "StepTooLarge",
    "Sweep",
    "TorqueDrive",
    "TorqueTable",
    "acceleration",
    "fit_friction",
    "least_power_gait",
    "load_scene",
    "load_session",
    "save_scene",
    "simulate",
    "simulate_gaits",
    "steady_gait",
    "steady_springs",
    "sweep",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module when it is first asked for."""
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_HOME_OF[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, imported or not."""
    return sorted(__all__)
