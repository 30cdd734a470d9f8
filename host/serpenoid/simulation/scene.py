"""Scene: everything that fixes one run of the simulator, checked before anything runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from ..base.checks import (
    NOT_NEGATIVE,
    POSITIVE,
    Limits,
    check_choice,
    check_fields,
    check_number,
    check_whole,
)
from ..base.errors import BadInput
from ..base.vectors import finite_vector
from ..model.core_model import check_parts
from ..model.drives import Servo, TorqueTable
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.link_state import LinkState
from ..model.robot import Robot

MAX_LINK_STEPS = 10**11
MIN_TOLERANCE = 1e-13
_LIMITS = {
    "joint_stiffness_n_m": NOT_NEGATIVE,
    "joint_damping_n_s_m": NOT_NEGATIVE,
    "incline_rad": Limits(0.0, math.pi / 2),
    "incline_direction_rad": Limits(-math.tau, math.tau),
    "tolerance": Limits(MIN_TOLERANCE, 0.1),
    "duration_s": NOT_NEGATIVE,
    "dt_s": POSITIVE,
}
_FIRMWARE_LIMITS = {
    "alpha_rad": math.pi / 2,
    "beta_rad": math.pi,
    "offset_rad": math.pi / 2,
    "omega_rad_s": 50.0,
}


@dataclass(frozen=True, slots=True)
class MethodKind:
    """Say which scenes a method runs; a row of host/core/scene/method_table.hpp.

    adaptive: formulations in which it
    takes steps of its own to scene.tolerance; in the others steps of dt_s. faults: whether it runs
    with limp or locked joints. Several words have blanks between them.
    """

    formulations: str
    adaptive: str
    laws: str
    faults: bool


METHODS = {row.pop("name"): MethodKind(**row) for row in _core.method_table()}


class OwnChoice(str):
    """Hold a method's name that a scene chose by itself: changed, the scene chooses anew."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Scene:
    """Describe one run of the simulator. SI units, radians. Raises BadInput.

    Attributes
    ----------
    robot
        What crawls.
    ground
        Friction of what it crawls on.
    gait
        How its joints move.
    formulation
        "explicit" (pinned joints) or "implicit" (Eqs. 51-56).
    joint_stiffness_n_m
        Stiffness k of the implicit formulation, N/m.
    joint_damping_n_s_m
        Damping c of the implicit formulation, N s/m.
    drive
        "angle": the gait's joint angles are imposed. "torque": `torque` acts. "servo": `servo`
        follows the gait as the firmware sends it.
    torque
        N m: a TorqueTable, an (n-1,) list of constants (which becomes a table), or a function of
        time.
    servo
        The servos of all joints.
    limp
        Joints without torque; they count from 1 at the tail.
    locked
        Joints that stay at an angle, rad, by their number.
    incline_rad
        Slope of the ground, rad. Friction stays as given: measure it on the slope.
    incline_direction_rad
        Direction in which the ground rises, rad, in its own frame (0: along x).
    method
        One of METHODS, or "auto": "nonsmooth" on dry ground, else "rk4". With "auto" the
        scene has the method's name, and chooses again when `replace` changes it. On dry ground all
        methods but "nonsmooth" use sgn 0 = 0. Wheels that should hold then chatter, the order is 1
        (the 2005 robot at 1 rad/s: rk4 is 3 % slow at 10 ms, 0.1 % at 1 ms), and recorded joint
        torques are wrong by a quarter at any step.
    dt_s
        Step of a method with fixed steps, s; for adaptive ones the grid of recorded times, s.
    tolerance
        Adaptive methods keep each step's error below it, relative: to body lengths and radians, of
        "dop853" to those times omega, too. "radau" follows ringing and decays that swing by more
        than it, and steps over the others: its rates are without these.
    duration_s
        Of the run, s.
    start
        "zero_momentum": from rest, link 1 at the origin along x; neither the centre of mass moves
        nor the chain turns as a whole. "link1_at_rest": x = y = theta_1 = 0 and their rates, as in
        the paper; the body then moves. "steady": from the periodic state. Or a LinkState.
    gap
        Start of the implicit formulation: "slow_manifold" (springs already carry the joint forces)
        or "zero".
    record
        "joints" adds forces and torques of the joints, "friction" the ground's force on each link.
        "energy" adds a ledger (kinetic energy, work, heat), integrated with the motion.
    record_every
        Keep one of so many steps; unless given every one, thinned to 20 000 rows.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> gait = sn.Gait(alpha_rad=0.5236, beta_rad=1.3963, omega_rad_s=5.0)
    >>> scene = sn.Scene(robot, ground, gait, method="rk4", dt_s=1e-3, duration_s=0.5)
    >>> scene.formulation, scene.adaptive
    ('explicit', False)
    """

    robot: Robot
    ground: Ground
    gait: Gait
    formulation: str = "explicit"
    joint_stiffness_n_m: float = 1e3
    joint_damping_n_s_m: float = 1.0
    drive: str = "angle"
    torque: TorqueTable | Callable[[float], ArrayLike] | ArrayLike | None = None
    servo: Servo | None = None
    limp: tuple[int, ...] = ()
    locked: Mapping[int, float] = field(default_factory=dict)
    incline_rad: float = 0.0
    incline_direction_rad: float = 0.0
    method: str = "auto"
    dt_s: float = 1e-3
    tolerance: float = 1e-7
    duration_s: float = 10.0
    start: str | LinkState = "zero_momentum"
    gap: str = "slow_manifold"
    record: tuple[str, ...] = ()
    record_every: int | None = None

    def __post_init__(self) -> None:
        check_parts(self.robot, self.ground, self.gait)
        for name in ("formulation", "drive", "gap"):
            check_choice(name, getattr(self, name))
        if not isinstance(self.method, OwnChoice):
            check_choice("method", self.method, ("auto", *METHODS))
        if isinstance(self.record, str) or not isinstance(self.record, Collection):
            raise BadInput(f"record is {self.record!r}; it must be a list of names")
        for name in self.record:
            check_choice("record", name)
        object.__setattr__(self, "record", tuple(self.record))
        check_fields(self, _LIMITS)
        self._check_counts()
        self.gait.joint_factors(self.robot.links - 1)
        self._check_drive()
        self._check_faults()
        if self.method == "auto" or isinstance(self.method, OwnChoice):
            object.__setattr__(self, "method", OwnChoice(default_method(self)))
        if (why := objection(self.method, self)) is not None:
            methods = (repr(name) for name in METHODS if objection(name, self) is None)
            raise BadInput(f"method {self.method!r} {why}; take method {', or '.join(methods)}")
        self._check_start()

    def _check_counts(self, max_bytes: float = 4e9) -> None:
        links = self.robot.links
        if self.record_every is not None:
            check_whole("record_every", self.record_every, 1)
        if self.duration_s / self.dt_s * links > MAX_LINK_STEPS:
            raise BadInput(
                f"duration_s {self.duration_s:g} at dt_s {self.dt_s:g} is more than "
                f"{MAX_LINK_STEPS / links:.2g} steps of {links} links; take a larger step or a "
                "shorter run"
            )
        values = 6 + 3 * ("joints" in self.record) + 2 * ("friction" in self.record)
        size = 8 * values * links * (self.steps / self.record_steps + 2)
        if size > max_bytes:
            raise BadInput(
                f"recording would take {size / 1e9:.3g} GB, more than {max_bytes / 1e9:g} GB; take "
                f"record_every {math.ceil(self.record_steps * size / max_bytes)} or more"
            )

    def _check_drive(self) -> None:
        for drive, value in (("torque", self.torque), ("servo", self.servo)):
            if (self.drive == drive) != (value is not None):
                raise BadInput(
                    f"drive is {self.drive!r} and {drive} is {value!r}; give {drive} with drive "
                    f"{drive!r} and only then"
                )
        joints, torque = self.robot.links - 1, self.torque
        if torque is not None and not callable(torque) and not isinstance(torque, TorqueTable):
            constants = finite_vector("torque", torque, joints)
            object.__setattr__(self, "torque", TorqueTable(np.zeros(1), constants[None]))
        if isinstance(torque, TorqueTable) and (columns := torque.torque_nm.shape[1]) != joints:
            raise BadInput(f"the torque table has {columns} columns; the robot has {joints} joints")
        if self.drive == "servo":
            self._check_firmware()

    def _check_firmware(self) -> None:
        # The gait in fixed point counts joints in a byte.
        check_whole("with drive 'servo', robot.links", self.robot.links, 2, 256)
        for name, limit in _FIRMWARE_LIMITS.items():
            value = getattr(self.gait, name)
            check_number(f"with drive 'servo', gait.{name}", value, -limit, limit)
        if self.gait.joint_gain or self.gait.joint_shift_rad:
            raise BadInput("the firmware's gait has no joint_gain or joint_shift_rad; leave them")

    def _check_faults(self) -> None:
        if not isinstance(self.limp, Collection) or not isinstance(self.locked, Mapping):
            raise BadInput(
                f"limp is {self.limp!r}, locked is {self.locked!r}; joints count from 1 at the "
                "tail: limp (2,), or locked {2: 0.0} with the angle, rad"
            )
        for name in ("limp", "locked"):
            for number in getattr(self, name):
                check_whole(f"a joint of {name}", number, 1, self.robot.links - 1)
        if doubly := set(self.limp) & set(self.locked):
            raise BadInput(f"joint {min(doubly)} is both limp and locked; choose one")
        locked = {
            j: check_number(f"locked[{j}]", a, -math.pi, math.pi) for j, a in self.locked.items()
        }
        object.__setattr__(self, "limp", tuple(sorted(set(self.limp))))
        object.__setattr__(self, "locked", locked)

    def _check_start(self) -> None:
        if not isinstance(self.start, LinkState):
            check_choice("start", self.start)
        elif self.start.links != self.robot.links:
            raise BadInput(f"start has {self.start.links} links, the robot has {self.robot.links}")
        if self.start == "steady" and (self.drive != "angle" or self.limp or self.locked):
            raise BadInput(
                "start 'steady' needs drive 'angle' and sound joints; give a LinkState, or take "
                "start 'zero_momentum'"
            )

    @property
    def law(self) -> str:
        """Return which friction law the ground makes of speeds: viscous or dry."""
        return "viscous" if self.ground.smooth else "dry"

    @property
    def steps(self) -> int:
        """Return the number of steps of dt_s that cover duration_s."""
        return math.ceil(self.duration_s / self.dt_s - 1e-9)

    @property
    def record_steps(self) -> int:
        """Return the number of dt_s between recorded times."""
        return self.record_every or max(1, math.ceil(self.steps / 20_000))

    @property
    def adaptive(self) -> bool:
        """Tell whether the method picks its own steps."""
        return self.formulation in METHODS[self.method].adaptive


def objection(name: str, scene: Scene) -> str | None:
    """Return why a method does not run a scene, or None if it does."""
    kind, servo = METHODS[name], scene.servo
    if scene.formulation not in kind.formulations:
        return f"does not run with formulation {scene.formulation!r}"
    if scene.law not in kind.laws:
        return f"does not run with law {scene.law!r}"
    names = "armature_kg_m2", "gear_friction_nm", "update_hz", "supply_sag"
    if name == "radau" and any(getattr(servo, part, 0.0) for part in names):
        return "does not run with rotors, gear friction, a loop that holds or a supply that sags"
    if name == "dop853" and servo is not None and servo.gear_friction_nm > 0:
        return "does not run with gear friction"
    if (scene.limp or scene.locked) and not kind.faults:
        return "does not run with limp or locked joints"
    return None


def default_method(scene: Scene) -> str:
    """Return the method for a scene that names none: exact sticking on dry ground, else rk4."""
    servo = scene.servo
    gears = servo is not None and servo.gear_friction_nm > 0
    dry = (scene.law == "dry" or gears) and objection("nonsmooth", scene) is None
    return "nonsmooth" if dry else "rk4"


def exact_scene(scene: Scene, tolerance: float) -> Scene:
    """Return a scene in the explicit formulation, by the most accurate method for it."""
    bare = replace(scene, formulation="explicit", method="auto")
    return replace(bare, tolerance=tolerance, method=most_accurate_method(bare))


def most_accurate_method(scene: Scene) -> str:
    """Return the method that gets a scene most accurate, of those that run it."""
    names = "radau", "dop853", "nonsmooth"
    return next(name for name in names if objection(name, scene) is None)
