"""Predict, drive and calibrate a wheeled snake robot; see the README for a first run."""

from .dynamics import Acceleration, AngleDrive, LinkState, TorqueDrive, acceleration
from .errors import BadInput, Diverged, NotConverged, SerpenoidError, StepTooLarge
from .model import Gait, Ground, Robot
from .optimize import LeastPower, least_power_gait
from .steady import Steady, Sweep, steady_gait, sweep

__all__ = [
    "Acceleration",
    "AngleDrive",
    "BadInput",
    "Diverged",
    "Gait",
    "Ground",
    "LeastPower",
    "LinkState",
    "NotConverged",
    "Robot",
    "SerpenoidError",
    "Steady",
    "StepTooLarge",
    "Sweep",
    "TorqueDrive",
    "acceleration",
    "least_power_gait",
    "steady_gait",
    "sweep",
]
