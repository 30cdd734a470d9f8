"""Types of the compiled core, generated: `.ci/stubs host/serpenoid/_core`."""

from collections.abc import Callable, Sequence
import enum
from typing import Annotated

import numpy
from numpy.typing import NDArray

from serpenoid._core import firmware as firmware

compiler: str

class Model:
    def __init__(
        self,
        arg0: int,
        arg1: float,
        arg2: float,
        arg3: float,
        arg4: float,
        arg5: float,
        arg6: float,
        arg7: float,
        arg8: float,
        arg9: float,
        arg10: float,
        arg11: float,
        arg12: float,
        arg13: float,
        /,
    ) -> None: ...
    def bent(self, arg0: float, arg1: float, /) -> Model: ...
    def set_joints(
        self,
        arg0: Annotated[
            NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)
        ],
        arg1: Annotated[
            NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)
        ],
        /,
    ) -> None: ...

class SteadyState:
    @property
    def speed(self) -> float: ...
    @property
    def chord(self) -> float: ...
    @property
    def power(self) -> float: ...
    @property
    def abs_power(self) -> float: ...
    @property
    def positive_power(self) -> float: ...
    @property
    def turn(self) -> float: ...
    @property
    def direction(self) -> float: ...
    @property
    def speed_error(self) -> float: ...
    @property
    def power_error(self) -> float: ...
    @property
    def positive_power_error(self) -> float: ...
    @property
    def turn_error(self) -> float: ...
    @property
    def slowest(self) -> float: ...
    @property
    def slowest_error(self) -> float: ...
    @property
    def elements(self) -> int: ...
    @property
    def iterations(self) -> int: ...
    @property
    def converged(self) -> bool: ...
    @property
    def start(self) -> tuple[float, ...]: ...
    @property
    def monodromy(self) -> tuple[float, ...]: ...

def steady(arg0: Model, arg1: float, arg2: bool, arg3: int, /) -> SteadyState: ...
def steady_by(arg0: str, arg1: Model, arg2: float, /) -> SteadyState: ...
def sweep(
    arg0: Sequence[Model],
    arg1: Sequence[float],
    arg2: float,
    arg3: bool,
    arg4: int,
    arg5: int,
    arg6: object | None,
    /,
) -> NDArray[numpy.float64]: ...

class Formulation(enum.Enum):
    explicit = 0

    implicit = 1

class Drive(enum.Enum):
    angle = 0

    torque = 1

    servo = 2

class Fault(enum.Enum):
    none = 0

    limp = 1

    locked = 2

class RunRequest:
    def __init__(self, arg: Model, /) -> None: ...
    @property
    def formulation(self) -> Formulation: ...
    @formulation.setter
    def formulation(self, arg: Formulation, /) -> None: ...
    @property
    def drive(self) -> Drive: ...
    @drive.setter
    def drive(self, arg: Drive, /) -> None: ...
    @property
    def faults(self) -> list[Fault]: ...
    @faults.setter
    def faults(self, arg: Sequence[Fault], /) -> None: ...
    @property
    def locked_rad(self) -> list[float]: ...
    @locked_rad.setter
    def locked_rad(self, arg: Sequence[float], /) -> None: ...
    @property
    def method(self) -> str: ...
    @method.setter
    def method(self, arg: str, /) -> None: ...
    @property
    def most_steps(self) -> int: ...
    @most_steps.setter
    def most_steps(self, arg: int, /) -> None: ...
    @property
    def record_joints(self) -> bool: ...
    @record_joints.setter
    def record_joints(self, arg: bool, /) -> None: ...
    @property
    def record_friction(self) -> bool: ...
    @record_friction.setter
    def record_friction(self, arg: bool, /) -> None: ...
    @property
    def record_energy(self) -> bool: ...
    @record_energy.setter
    def record_energy(self, arg: bool, /) -> None: ...
    def set_slope(self, arg0: float, arg1: float, /) -> None: ...
    def set_servo(
        self, arg0: float, arg1: float, arg2: float, arg3: float, arg4: float, /
    ) -> None: ...
    def set_torque_function(self, arg: Callable, /) -> None: ...
    def set_torque_table(self, arg0: Sequence[float], arg1: Sequence[float], /) -> None: ...
    @property
    def joint_stiffness_n_m(self) -> float: ...
    @joint_stiffness_n_m.setter
    def joint_stiffness_n_m(self, arg: float, /) -> None: ...
    @property
    def joint_damping_n_s_m(self) -> float: ...
    @joint_damping_n_s_m.setter
    def joint_damping_n_s_m(self, arg: float, /) -> None: ...
    @property
    def smoothing_m_s(self) -> float: ...
    @smoothing_m_s.setter
    def smoothing_m_s(self, arg: float, /) -> None: ...
    @property
    def dt_s(self) -> float: ...
    @dt_s.setter
    def dt_s(self, arg: float, /) -> None: ...
    @property
    def tolerance(self) -> float: ...
    @tolerance.setter
    def tolerance(self, arg: float, /) -> None: ...
    @property
    def duration_s(self) -> float: ...
    @duration_s.setter
    def duration_s(self, arg: float, /) -> None: ...
    @property
    def steps(self) -> int: ...
    @steps.setter
    def steps(self, arg: int, /) -> None: ...
    @property
    def every(self) -> int: ...
    @every.setter
    def every(self, arg: int, /) -> None: ...

SCENE_FIELDS: tuple

def run(
    arg0: RunRequest,
    arg1: Annotated[
        NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)
    ],
    arg2: object | None,
    /,
) -> dict: ...
def evaluate(
    arg0: RunRequest,
    arg1: Annotated[
        NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)
    ],
    arg2: Annotated[
        NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)
    ],
    /,
) -> dict: ...
def method_table() -> list: ...

class BatchScene:
    def __init__(
        self,
        arg0: int,
        arg1: float,
        arg2: float,
        arg3: float,
        arg4: float,
        arg5: float,
        arg6: float,
        arg7: float,
        arg8: float,
        arg9: float,
        arg10: float,
        arg11: float,
        arg12: float,
        /,
    ) -> None: ...

def instruction_sets() -> list[str]: ...
def run_batch(
    arg0: BatchScene,
    arg1: Annotated[
        NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)
    ],
    arg2: Annotated[
        NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)
    ],
    arg3: float,
    arg4: float,
    arg5: int,
    arg6: str,
    arg7: bool,
    /,
) -> tuple: ...
def kernel_sincos(
    arg0: str,
    arg1: Annotated[
        NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)
    ],
    /,
) -> NDArray[numpy.float64]: ...

class FreeChain:
    def __init__(
        self,
        arg0: float,
        arg1: float,
        arg2: float,
        arg3: Annotated[
            NDArray[numpy.float64],
            dict(shape=(None, None), order="C", device="cpu", writable=False),
        ],
        /,
    ) -> None: ...
    def place(
        self, arg0: float, arg1: float, arg2: float, arg3: float, arg4: float, arg5: float, /
    ) -> None: ...
    def set_joints(self, arg: Sequence[float], /) -> None: ...
    def aim(self, arg0: Sequence[float], arg1: float, /) -> None: ...
    def set_slope(self, arg0: float, arg1: float, /) -> None: ...
    def set_ground_velocity(self, arg0: float, arg1: float, /) -> None: ...
    def advance(self, arg0: float, arg1: float, /) -> bool: ...
    def lead(self, arg0: Sequence[float], arg1: float, arg2: float, /) -> bool: ...
    @property
    def state(self) -> list[float]: ...
    @property
    def joints(self) -> list[float]: ...
    @property
    def kinetic_j(self) -> float: ...
    @property
    def places(self) -> list[float]: ...
