"""Solve for the periodic state of a gait, with ideal joints or with servos.

The modules for servos are imported at their first use, since that takes as long as a gait.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, overload

from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.steady import Steady, speed_floor_m_s
from ..periodic.steady import steady_gait as ideal_gait

if TYPE_CHECKING:
    from ..model.drives import Servo, ServoKind
    from ..periodic.servo_steady import ServoSteady


@overload
def steady_gait(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    *,
    rtol: float = ...,
    powers: bool = ...,
    servo: None = None,
    sensitivities: bool = ...,
    from_rest: bool = ...,
) -> Steady: ...
@overload
def steady_gait(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    *,
    rtol: float = ...,
    powers: bool = ...,
    servo: Servo | ServoKind,
    sensitivities: bool = ...,
    from_rest: bool = ...,
) -> ServoSteady: ...
def steady_gait(
    robot: Robot,
    ground: Ground,
    gait: Gait,
    *,
    rtol: float = 1e-6,
    powers: bool = True,
    servo: Servo | ServoKind | None = None,
    sensitivities: bool = False,
    from_rest: bool = False,
) -> Steady | ServoSteady:
    """Solve for the periodic state of a gait: joints that follow it exactly, or moved by servos.

    Parameters
    ----------
    robot, ground, gait : Robot, Ground, Gait
        The robot, the friction of the ground on a link, and the motion of the joints.
    rtol : float
        Relative accuracy of speed and net power of ideal joints, 0.1 to 1e-12. On dry ground it is
        1e-7 at best, and net power is accurate to 10 rtol. The other powers have their own stated
        errors.
    powers : bool
        Whether to compute abs_power_w and positive_power_w, W; they are 0 if not.
    servo : Servo or ServoKind, optional
        The servo that moves the joints; None for joints that follow the gait exactly.
    sensitivities : bool
        Whether to compute by how many per cent the speed changes for 1 % of mass, length,
        amplitude, lag, rate and both frictions, with ideal joints.
    from_rest : bool
        Whether to simulate starts from rest, and on viscous ground of low friction other starts
        too, for the state's `from_rest`. It takes two seconds at most.

    Returns
    -------
    Steady or ServoSteady
        The periodic state with ideal joints; with a servo, the motion that it drives, which has
        the state with ideal joints as `ideal`.

    Raises
    ------
    BadInput
        If a parameter is outside its limits.
    NotConverged
        If no state was found to rtol; the error's `best` is the best one.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=0.0756, link_length_m=0.076)
    >>> ground = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
    >>> gait = sn.Gait(alpha_rad=1.22, beta_rad=1.31, omega_rad_s=4.0)
    >>> s = sn.steady_gait(robot, ground, gait)
    >>> round(s.speed_m_s, 4)
    0.1211
    """
    ideal = ideal_gait(robot, ground, gait, rtol=rtol, powers=powers)
    if sensitivities:
        from ..periodic.sensitivities import speed_sensitivities

        floor_m_s = speed_floor_m_s(robot, gait.omega_rad_s)
        changes = speed_sensitivities(robot, ground, gait, floor_m_s)
        ideal = replace(ideal, sensitivities=changes)
    if from_rest:
        from .from_rest import from_rest as follow

        ideal = replace(ideal, from_rest=follow(ideal))
    if servo is None:
        return ideal
    from ..periodic.servo_steady import with_servo

    return with_servo(ideal, servo)
