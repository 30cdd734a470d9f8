"""Types of the compiled core, for the checker."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

class Model:
    def __init__(
        self, n: int, mass: float, half_length: float, inertia: float,
        ct: float, cn: float, ft0: float, fn0: float,
        alpha: float, beta: float, omega: float, offset: float, /,
    ) -> None: ...  # fmt: skip

class SteadyState:
    speed: float
    power: float
    abs_power: float
    positive_power: float
    turn: float
    direction: float
    speed_error: float
    power_error: float
    elements: int
    iterations: int
    converged: bool
    start: Array
    monodromy: Array

def steady(model: Model, rtol: float, powers: bool, max_elements: int, /) -> SteadyState: ...
def steady_row(
    model: Model, omegas: Array, rtol: float, powers: bool, max_elements: int, /
) -> Array: ...
def evaluate(
    model: Model, implicit: bool, torque: bool, k: float, c: float, smoothing: float,
    links: Array, drive: Array, /,
) -> dict[str, Array]: ...  # fmt: skip
def run(
    model: Model, implicit: bool, torque: Callable[[float], Array] | None, nonsmooth: bool,
    k: float, c: float, smoothing: float, dt: float, duration: float, steps: int, every: int,
    record_joints: bool, start: Array, /,
) -> dict[str, Any]: ...  # fmt: skip

class firmware:  # a submodule; the checker takes its names from here
    class Board:
        def __init__(self, start_us: int = 0) -> None: ...
        def boot(self, reset: str = "power", first_frame: int = 0) -> None: ...
        def run(self, seconds: float) -> None: ...
        def stall(self, seconds: float) -> None: ...
        def write(self, data: bytes) -> None: ...
        def read(self) -> bytes: ...
        eeprom: bytes
        @property
        def time_s(self) -> float: ...
        @property
        def state(self) -> str: ...
        @property
        def setpoints_rad(self) -> list[float]: ...

class LaneScene:
    def __init__(
        self, n: int, mass: float, half_length: float, inertia: float,
        ct: float, cn: float, ft0: float, fn0: float, k: float, c: float, smoothing: float, /,
    ) -> None: ...  # fmt: skip

def lane_sets() -> list[str]: ...
def lane_run(
    scene: LaneScene, gaits: Array, starts: Array, dt: float, duration: float, steps: int,
    kernels: str, batch: bool, /,
) -> tuple[Array, Array]: ...  # fmt: skip
def lane_sincos(kernels: str, x: Array, /) -> Array: ...
