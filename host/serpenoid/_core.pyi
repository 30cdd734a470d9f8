"""Types of the compiled core, for the checker."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

compiler: str

class Model:
    def __init__(
        self, n: int, mass: float, half_length: float, inertia: float,
        ct: float, cn: float, ft0: float, fn0: float,
        alpha: float, beta: float, omega: float, offset: float, /,
    ) -> None: ...  # fmt: skip
    def set_joints(self, gain: Array, shift: Array, /) -> None: ...

class SteadyState:
    speed: float
    chord: float
    power: float
    abs_power: float
    positive_power: float
    turn: float
    direction: float
    speed_error: float
    power_error: float
    positive_power_error: float
    slowest: float
    slowest_error: float
    elements: int
    iterations: int
    converged: bool
    start: Array
    monodromy: Array

def steady(model: Model, rtol: float, powers: bool, max_elements: int, /) -> SteadyState: ...
def sweep(
    models: list[Model], omegas: list[float], rtol: float, powers: bool, max_elements: int,
    threads: int, progress: Callable[[int], None] | None, /,
) -> Array: ...  # fmt: skip

class Formulation:
    explicit: Formulation
    implicit: Formulation

class Drive:
    angle: Drive
    torque: Drive
    servo: Drive

class Fault:
    none: Fault
    limp: Fault
    locked: Fault

class RunRequest:
    def __init__(self, model: Model, /) -> None: ...
    formulation: Formulation
    drive: Drive
    faults: list[Fault]
    locked_rad: list[float]
    joint_stiffness_n_m: float
    joint_damping_n_s_m: float
    smoothing_m_s: float
    method: str
    dt_s: float
    tolerance: float
    duration_s: float
    steps: int
    most_steps: int
    every: int
    record_joints: bool
    record_friction: bool
    record_energy: bool
    def set_slope(self, gx: float, gy: float, /) -> None: ...
    def set_servo(
        self, stiffness: float, damping: float, torque: float, speed: float, dead_band: float, /
    ) -> None: ...
    def set_torque_function(self, f: Callable[[float], Array], /) -> None: ...
    def set_torque_table(self, t_s: list[float], torque_nm: list[float], /) -> None: ...

SCENE_FIELDS: tuple[str, ...]

def method_table() -> list[dict[str, Any]]: ...
def evaluate(request: RunRequest, links: Array, drive: Array, /) -> dict[str, Array]: ...
def run(
    request: RunRequest, start: Array, progress: Callable[[float], object] | None, /
) -> dict[str, Any]: ...

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

class BatchScene:
    def __init__(
        self, n: int, mass: float, half_length: float, inertia: float,
        ct: float, cn: float, ft0: float, fn0: float, k: float, c: float, smoothing: float, /,
    ) -> None: ...  # fmt: skip

def instruction_sets() -> list[str]: ...
def run_batch(
    scene: BatchScene, gaits: Array, starts: Array, dt: float, duration: float, steps: int,
    kernels: str, batch: bool, /,
) -> tuple[Array, Array]: ...  # fmt: skip
def kernel_sincos(kernels: str, x: Array, /) -> Array: ...
