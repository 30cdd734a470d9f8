"""Predict, drive and calibrate a wheeled snake robot; see the README for a first run."""

from __future__ import annotations

TYPE_CHECKING = False  # `typing` takes longer to import than all else that the command line needs
if TYPE_CHECKING:
    from typing import Any

    __version__: str
    from .base.errors import BadInput, Diverged, NotConverged, SerpenoidError, StepTooLarge
    from .friction.file import load_fit, save_fit
    from .friction.fit import fit_friction
    from .friction.result import FrictionFit
    from .gaits.least_power import LeastPower, least_power_gait, power_front
    from .gaits.limits import GaitLimits, SpeedLosses, speed_losses
    from .model.drives import Servo, ServoKind, TorqueTable
    from .model.evaluation import Acceleration, acceleration
    from .model.gait import Gait
    from .model.ground import Ground
    from .model.link_state import LinkState
    from .model.robot import Robot
    from .periodic.servo_steady import ServoSteady
    from .periodic.steady import Steady
    from .periodic.sweep import Sweep, sweep
    from .prediction.advice import Advice, advise
    from .prediction.comparison import Comparison, compare
    from .servos.catalogue import load_servo, save_servo, servo
    from .session.folder import load_session
    from .session.session import Session
    from .simulation.run import Run
    from .simulation.scene import Scene
    from .simulation.scene_file import load_scene, save_scene
    from .simulation.simulate import simulate
    from .simulation.steady_gait import steady_gait
    from .simulation.steady_springs import SteadySprings, steady_springs

# Where the rest is, imported at first use: the command line answers --help without NumPy.
_HOMES = {
    "base.errors": ("BadInput", "Diverged", "NotConverged", "SerpenoidError", "StepTooLarge"),
    "prediction.advice": ("Advice", "advise"),
    "prediction.comparison": ("Comparison", "compare"),
    "friction.file": ("load_fit", "save_fit"),
    "friction.fit": ("fit_friction",),
    "friction.result": ("FrictionFit",),
    "session.session": ("Session",),
    "session.folder": ("load_session",),
    "model.drives": ("Servo", "ServoKind", "TorqueTable"),
    "model.evaluation": ("Acceleration", "acceleration"),
    "model.gait": ("Gait",),
    "model.ground": ("Ground",),
    "model.link_state": ("LinkState",),
    "model.robot": ("Robot",),
    "gaits.least_power": ("LeastPower", "least_power_gait", "power_front"),
    "gaits.limits": ("GaitLimits", "SpeedLosses", "speed_losses"),
    "periodic.servo_steady": ("ServoSteady",),
    "simulation.steady_gait": ("steady_gait",),
    "periodic.steady": ("Steady",),
    "servos.catalogue": ("servo", "load_servo", "save_servo"),
    "periodic.sweep": ("Sweep", "sweep"),
    "simulation.steady_springs": ("SteadySprings", "steady_springs"),
    "simulation.scene": ("Scene",),
    "simulation.scene_file": ("load_scene", "save_scene"),
    "simulation.run": ("Run",),
    "simulation.simulate": ("simulate",),
}
_HOME_OF: dict[str, str] = {}
for _home, _names in _HOMES.items():
    _HOME_OF.update(dict.fromkeys(_names, _home))

__all__ = [
    "Acceleration",
    "Advice",
    "BadInput",
    "Comparison",
    "Diverged",
    "FrictionFit",
    "Gait",
    "GaitLimits",
    "Ground",
    "LeastPower",
    "LinkState",
    "NotConverged",
    "Robot",
    "Run",
    "Scene",
    "SerpenoidError",
    "Servo",
    "ServoKind",
    "ServoSteady",
    "Session",
    "SpeedLosses",
    "Steady",
    "SteadySprings",
    "StepTooLarge",
    "Sweep",
    "TorqueTable",
    "acceleration",
    "advise",
    "compare",
    "fit_friction",
    "least_power_gait",
    "load_fit",
    "load_scene",
    "load_servo",
    "load_session",
    "power_front",
    "save_fit",
    "save_scene",
    "save_servo",
    "servo",
    "simulate",
    "speed_losses",
    "steady_gait",
    "steady_springs",
    "sweep",
]


def __getattr__(name: str) -> Any:
    """Import a public name from its module when it is first asked for."""
    if name == "__version__":
        from importlib.metadata import version

        return version(__name__)
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    value = getattr(importlib.import_module(f".{_HOME_OF[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, imported or not."""
    return sorted(__all__)
