"""The two robots of the 2005 paper on their ground, by the names that --robot takes."""

from __future__ import annotations

from .ground import Ground
from .robot import Robot

# The robot of the paper's experiment, whose dry friction is measured, and the one of its theory.
PRESETS = {
    "2005": (Robot(6, 0.0756, 0.076), Ground.whole_body(6, 0.084, 1.2, 0.14, 0.27)),
    "paper": (Robot(6, 1.0, 0.12), Ground(0.1, 10.0)),
}
