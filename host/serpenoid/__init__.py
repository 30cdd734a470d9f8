"""Predict, drive and calibrate a wheeled snake robot; see the README for a first run."""

from .errors import BadInput, Diverged, NotConverged, SerpenoidError, StepTooLarge
from .model import Gait, Ground, Robot

__all__ = [
    "BadInput",
    "Diverged",
    "Gait",
    "Ground",
    "NotConverged",
    "Robot",
    "SerpenoidError",
    "StepTooLarge",
]
