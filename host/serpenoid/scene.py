"""Scene: everything that fixes one run of the simulator, checked before anything runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .dynamics import FORMULATIONS, LinkState
from .errors import BadInput, check_choice, check_number
from .model import Gait, Ground, Robot

DRIVES = ("angle", "torque")
LAWS = ("viscous", "smoothed", "dry")
STARTS = ("link1_at_rest", "zero_momentum", "steady")
GAPS = ("slow_manifold", "zero")
RECORDS = ("joints",)
MAX_STEPS = 10**10
MAX_RECORDED_BYTES = 4_000_000_000


@dataclass(frozen=True, slots=True)
class MethodKind:
    """Say which scenes a method in time runs; `adaptive`: where it takes steps of its own."""

    formulations: tuple[str, ...] = FORMULATIONS
    adaptive: tuple[str, ...] = ()  # formulations; in the others steps of dt_s
    drives: tuple[str, ...] = DRIVES
    laws: tuple[str, ...] = LAWS


METHODS = {
    "rk4": MethodKind(),
    "nonsmooth": MethodKind(adaptive=("explicit",), drives=("angle",), laws=("viscous", "dry")),
}


@dataclass(frozen=True, slots=True)
class TorqueTable:
    """Hold joint torques by time: t_s (K,) rising, torque_nm (K, n-1), linear in between.

    Before the first time and after the last the first and last rows hold.
    """

    t_s: NDArray[np.float64]
    torque_nm: NDArray[np.float64]

    def __post_init__(self) -> None:
        t, T = np.asarray(self.t_s, dtype=float), np.asarray(self.torque_nm, dtype=float)
        if t.ndim != 1 or T.ndim != 2 or t.size == 0 or T.shape[0] != t.size:
            raise BadInput(
                f"a torque table needs t_s (K,) and torque_nm (K, n-1); got {t.shape}, {T.shape}"
            )
        if not (np.isfinite(t).all() and np.isfinite(T).all() and (np.diff(t) > 0).all()):
            raise BadInput("a torque table needs finite torques at finite, rising times")
        object.__setattr__(self, "t_s", t)
        object.__setattr__(self, "torque_nm", T)

    def __call__(self, t_s: float) -> NDArray[np.float64]:
        """Return the torques at a time, (n-1,)."""
        k = int(np.searchsorted(self.t_s, t_s))
        if k in (0, self.t_s.size):
            return self.torque_nm[min(k, self.t_s.size - 1)].copy()
        f = (t_s - self.t_s[k - 1]) / (self.t_s[k] - self.t_s[k - 1])
        return (1 - f) * self.torque_nm[k - 1] + f * self.torque_nm[k]


@dataclass(frozen=True, slots=True)
class Scene:
    """Describe one run of the simulator.

    formulation: "explicit" (pinned joints) or "implicit" (Eqs. 51-56 with joint_stiffness_n_m k and
    joint_damping_n_s_m c). drive: "angle" (the gait's joint angles are imposed) or "torque"
    (`torque`, N m, is a TorqueTable, an (n-1,) list of constants, or a function of time).
    method: "rk4" with step dt_s, or "nonsmooth" (dry friction as the set-valued law: adaptive steps
    for the explicit, shrinking steps of dt_s for the implicit formulation). start: "link1_at_rest"
    (x = y = theta_1 = 0 and their rates; the paper's), "zero_momentum", "steady" (from the periodic
    state) or a LinkState. gap: what the implicit formulation starts from, "slow_manifold" (springs
    already carry the joint forces, no ringing) or "zero". smoothing_m_s: above 0 dry friction is
    smoothed by that width, for study. record: "joints" adds forces and torques of the joints;
    record_every: keep each of so many steps. SI units, radians. Raises BadInput.
    """

    robot: Robot
    ground: Ground
    gait: Gait
    formulation: str = "explicit"
    joint_stiffness_n_m: float = 1e3
    joint_damping_n_s_m: float = 1.0
    drive: str = "angle"
    torque: TorqueTable | Callable[[float], ArrayLike] | ArrayLike | None = None
    method: str = "rk4"
    dt_s: float = 1e-3
    duration_s: float = 10.0
    start: str | LinkState = "link1_at_rest"
    gap: str = "slow_manifold"
    smoothing_m_s: float = 0.0
    record: tuple[str, ...] = field(default=())
    record_every: int = 1

    def __post_init__(self) -> None:
        check_choice("formulation", self.formulation, FORMULATIONS)
        check_choice("drive", self.drive, DRIVES)
        check_choice("method", self.method, tuple(METHODS))
        check_choice("gap", self.gap, GAPS)
        for name in self.record:
            check_choice("record", name, RECORDS)
        check_number("joint_stiffness_n_m", self.joint_stiffness_n_m, 0.0)
        check_number("joint_damping_n_s_m", self.joint_damping_n_s_m, 0.0)
        check_number("smoothing_m_s", self.smoothing_m_s, 0.0)
        check_number("dt_s", self.dt_s, 0.0, open_low=True)
        check_number("duration_s", self.duration_s, 0.0)
        self._check_counts()
        self._check_drive()
        self._check_start()

    def _check_counts(self) -> None:
        every = self.record_every
        if isinstance(every, bool) or not isinstance(every, int) or every < 1:
            raise BadInput(f"record_every is {every!r}; it must be a whole number, 1 or more")
        if self.duration_s / self.dt_s > MAX_STEPS:
            raise BadInput(
                f"duration_s {self.duration_s:g} at dt_s {self.dt_s:g} is more than "
                f"{MAX_STEPS:.0e} steps; take a larger step or a shorter run"
            )
        values = 6 + (3 if "joints" in self.record else 0)
        size = 8 * values * self.robot.links * (self.steps / every + 2)
        if size > MAX_RECORDED_BYTES:
            raise BadInput(
                f"recording would take {size / 1e9:.3g} GB, more than "
                f"{MAX_RECORDED_BYTES / 1e9:g} GB; take record_every "
                f"{math.ceil(every * size / MAX_RECORDED_BYTES)} or more"
            )

    def _check_drive(self) -> None:
        if (self.drive == "torque") != (self.torque is not None):
            raise BadInput(
                f"drive is {self.drive!r} and torque is {self.torque!r}; give torque with drive "
                "'torque' and only then"
            )
        self._check_method()
        joints = self.robot.links - 1
        if isinstance(self.torque, TorqueTable) and self.torque.torque_nm.shape[1] != joints:
            columns = self.torque.torque_nm.shape[1]
            raise BadInput(f"the torque table has {columns} columns; the robot has {joints} joints")

    def _check_method(self) -> None:
        for name in ("formulation", "drive", "law"):
            value, runs = getattr(self, name), f"{name}s"
            if value not in getattr(METHODS[self.method], runs):
                others = [repr(m) for m, kind in METHODS.items() if value in getattr(kind, runs)]
                raise BadInput(
                    f"method {self.method!r} does not run with {name} {value!r}; take method "
                    f"{' or '.join(others)}"
                )

    def _check_start(self) -> None:
        if not isinstance(self.start, LinkState):
            check_choice("start", self.start, STARTS)
        elif self.start.links != self.robot.links:
            raise BadInput(f"start has {self.start.links} links, the robot has {self.robot.links}")
        if self.start == "steady" and self.drive != "angle":
            raise BadInput("start 'steady' needs drive 'angle'; give a LinkState instead")

    @property
    def law(self) -> str:
        """Return which friction law the ground makes of the links' speeds, one of LAWS."""
        if self.smoothing_m_s > 0:
            return "smoothed"
        return "dry" if self.ground.dry else "viscous"

    @property
    def steps(self) -> int:
        """Return the number of steps of dt_s that cover duration_s."""
        return math.ceil(self.duration_s / self.dt_s - 1e-9)
