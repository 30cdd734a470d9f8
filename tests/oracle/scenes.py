"""Whole scenes the slow way: any drive, fault, slope and friction law on the dense models, stepped.

What is free to move is z = (x, y of link 1, theta_1, free joints) for pinned joints, or z = (x, y
of the centre of mass, gaps of all joints, theta_1, free joints) for springs; the rest follows from
the gait. Every force is written down link by link; accelerations come from dense.evaluate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import serpenoid as sn
from serpenoid import _core

from . import dense
from .dense import Motion
from .params import Array, Gait, Params

FRAME_S = 0.02
NAMES = (
    *("x_m", "y_m", "theta_rad", "vx_m_s", "vy_m_s", "omega_rad_s"),
    *("joint_force_x_n", "joint_force_y_n", "joint_torque_nm", "friction_x_n", "friction_y_n"),
    "energy_j",
)


def params_of(scene: sn.Scene) -> Params:
    """Return the reference's parameters of a scene; the ground falls against its direction."""
    robot, ground = scene.robot, scene.ground
    pull = 9.80665 * math.sin(scene.incline_rad)
    gravity = (
        -pull * math.cos(scene.incline_direction_rad),
        -pull * math.sin(scene.incline_direction_rad),
    )
    return Params(
        robot.links,
        robot.link_mass_kg,
        robot.link_length_m / 2,
        robot.inertia_kg_m2,
        ground.ct_forward,
        ground.cn,
        ground.ft0_forward,
        ground.fn0,
        gravity,
        ground.ct_backward,
        ground.ft0_backward,
    )


def servo_duties(servo: sn.Servo, error_rad: Array, rate: Array) -> Array:
    """Return the duties of all servos, (n-1,), of errors and rates of their joints."""
    found = []
    for error, speed in zip(error_rad, rate, strict=True):
        left = 0.0
        if abs(error) > servo.dead_band_rad:
            left = error - math.copysign(servo.dead_band_rad, error)
        wanted = servo.stiffness_nm_rad * left - servo.damping_nms_rad * speed
        duty = wanted / servo.torque_limit_nm + speed / servo.speed_limit_rad_s
        found.append(max(-1.0, min(1.0, duty)))
    return np.array(found)


def servo_torques(servo: sn.Servo, duty: Array, rate: Array) -> Array:
    """Return the torque that each servo puts into its joint, positive where it raises the angle.

    A motor is a voltage behind a resistance: the current is what the voltage leaves of the back
    EMF, over the resistance; here both in units of a stalled motor at full voltage. A bridge takes
    duty times it from the supply, which falls by the share `supply_sag` for each unit, and never
    rises.
    """
    low, high = 0.0, 1.0  # the supply's voltage, by bisection
    back = rate / servo.speed_limit_rad_s
    for _ in range(80):
        supply = (low + high) / 2
        taken = np.sum(duty * (supply * duty - back))
        if 1 - servo.supply_sag * taken > supply:
            low = supply
        else:
            high = supply
    current = (low + high) / 2 * duty - back
    gear = servo.gear_friction_nm * np.sign(rate) + servo.gear_damping_nms_rad * rate
    return servo.torque_limit_nm * current - gear


@dataclass
class SlowScene:
    """Hold a scene and what its steps hold on to: setpoints, duties and damper rates."""

    scene: sn.Scene
    setpoint_rad: Array = field(default_factory=lambda: np.zeros(0))
    duty: Array | None = None  # of servos that hold it
    held_gap_rate: Array | None = None  # (n-1, 2), of the paper's scheme

    def __post_init__(self) -> None:
        s = self.scene
        self.p = params_of(s)
        self.gait = Gait(s.gait.alpha_rad, s.gait.beta_rad, s.gait.omega_rad_s, s.gait.offset_rad)
        self.spring = dense.Spring(s.joint_stiffness_n_m, s.joint_damping_n_s_m)
        numbers = range(1, s.robot.links)
        by_angle = s.drive == "angle"
        self.driven = np.array([j in s.locked or (by_angle and j not in s.limp) for j in numbers])
        self.pinned = s.formulation == "explicit"

    def enter(self, t_s: float, y: Array) -> None:
        """Take the setpoints of the frame that begins at or before a time, and the duties."""
        servo = self.scene.servo
        if servo is None:
            return
        g, frame = self.scene.gait, math.floor(t_s / FRAME_S + 1e-9)
        self.setpoint_rad = _core.firmware.gait_setpoints_rad(
            g.alpha_rad,
            g.beta_rad,
            g.omega_rad_s,
            offset_rad=g.offset_rad,
            first_frame=frame,
            joints=self.p.links - 1,
        )[0]
        updates = t_s * servo.update_hz
        if servo.update_hz > 0 and abs(updates - round(updates)) < 1e-6:
            pose, rates, _ = self.links(t_s, y)
            error = self.setpoint_rad - np.diff(pose[:, 2])
            self.duty = servo_duties(servo, error, np.diff(rates[:, 2]))

    def joints(self, t_s: float) -> tuple[Array, Array, Array]:
        """Return imposed angles and their rates, each (n-1,); what is free has to be filled in."""
        phi, rate, bend = self.gait.angles(t_s, self.p.links - 1)
        for joint, angle in self.scene.locked.items():
            phi[joint - 1], rate[joint - 1], bend[joint - 1] = angle, 0.0, 0.0
        return phi, rate, bend

    def links(self, t_s: float, y: Array) -> tuple[Array, Array, Array]:
        """Return pose and rates (n, 3) of all links and phi'' (n-1,); y = (z, z', integrals)."""
        n, free = self.p.links, ~self.driven
        centres = 2 if self.pinned else 2 * n
        size = centres + 1 + free.sum()
        phi, phi_rate, bend = self.joints(t_s)
        both = []
        for z, joint in ((y[:size], phi), (y[size : 2 * size], phi_rate)):
            joint[free] = z[centres + 1 :]
            angle = z[centres] + np.concatenate([[0.0], np.cumsum(joint)])
            both.append((z[:centres], angle))
        if self.pinned:
            q, qdot = (np.concatenate(pair) for pair in both)
            return *dense.closed_links(self.p, q, qdot), bend
        (z, theta), (z_rate, omega) = both
        tangent, normal = dense.axes(theta)
        half = self.p.half_length_m
        place = centres_of(z, half * tangent)
        velocity = centres_of(z_rate, half * omega[:, None] * normal)
        return np.column_stack([place, theta]), np.column_stack([velocity, omega]), bend

    def pack(self, start: sn.LinkState) -> Array:
        """Return y of a start, with four integrals of nothing behind."""
        free = ~self.driven
        pose = np.column_stack([start.x_m, start.y_m, start.theta_rad])
        rates = np.column_stack([start.vx_m_s, start.vy_m_s, start.omega_rad_s])
        gap, gap_rate = dense.joint_gaps(self.p, pose, rates)
        both = []
        for links, gaps in ((pose, gap), (rates, gap_rate)):
            centres = links[:, :2]
            lengths = [centres[0]] if self.pinned else [centres.mean(axis=0), gaps.ravel()]
            both += [*lengths, links[:1, 2], np.diff(links[:, 2])[free]]
        return np.concatenate([*both, np.zeros(4)])

    def torque(self, t_s: float, pose: Array, rates: Array) -> Array:
        """Return T_i (n-1,) of the joints that are not imposed, on link i from link i+1."""
        s, joints = self.scene, self.p.links - 1
        if s.drive == "servo":
            assert s.servo is not None
            error, rate = self.setpoint_rad - np.diff(pose[:, 2]), np.diff(rates[:, 2])
            duty = servo_duties(s.servo, error, rate) if self.duty is None else self.duty
            torque = -servo_torques(s.servo, duty, rate)
        elif isinstance(s.torque, sn.TorqueTable):
            columns = s.torque.torque_nm.T
            torque = np.array([np.interp(t_s, s.torque.t_s, column) for column in columns])
        elif callable(s.torque):
            torque = np.array(s.torque(t_s))
        else:
            torque = np.zeros(joints) if s.torque is None else np.array(s.torque)
        torque[[j - 1 for j in s.limp]] = 0.0
        return torque

    def motion(self, t_s: float, y: Array) -> tuple[Motion, Array, Array]:
        """Return accelerations and forces, and pose and rates, at a state."""
        pose, rates, bend = self.links(t_s, y)
        joints = {"torque": self.torque(t_s, pose, rates), "phi_ddot": bend, "driven": self.driven}
        if self.scene.servo is not None:
            sound = [j not in self.scene.limp for j in range(1, self.p.links)]
            joints["rotor"] = np.where(sound, self.scene.servo.armature_kg_m2, 0.0)
        if not self.pinned:
            joints |= {"spring": self.spring, "gap_rate": self.held_gap_rate}
        return dense.evaluate(self.p, pose, rates, **joints), pose, rates

    def rate(self, t_s: float, y: Array) -> Array:
        """Return y': rates, accelerations, and the powers of joints, friction, dampers, servos."""
        m, pose, rates = self.motion(t_s, y)
        free = ~self.driven
        size = (len(y) - 4) // 2
        accel = [m.accel_m_s2[0]]
        if not self.pinned:
            rows, drift = dense.gap_rows(self.p, pose, rates)
            gap_accel = rows @ np.column_stack([m.accel_m_s2, m.theta_ddot]).ravel() + drift
            accel = [m.accel_m_s2.mean(axis=0), gap_accel]
        accel += [m.theta_ddot[:1], np.diff(m.theta_ddot)[free]]
        power = -m.torque_n_m * np.diff(rates[:, 2])
        damped = 0.0
        if not self.pinned:
            gap, gap_rate = dense.joint_gaps(self.p, pose, rates)
            damped = np.sum((m.force_n - self.spring.stiffness_n_m * gap) * gap_rate)
        heat = -np.sum(m.friction_n * rates[:, :2])
        powers = [power.sum(), heat, damped, power[power > 0].sum()]
        return np.concatenate([y[size : 2 * size], *accel, powers])

    def stores(self, t_s: float, y: Array) -> Array:
        """Return kinetic energy, energy of the springs, and energy of height, J."""
        pose, rates, _ = self.links(t_s, y)
        p, springs = self.p, 0.0
        if not self.pinned:
            springs = (
                self.spring.stiffness_n_m / 2 * np.sum(dense.joint_gaps(p, pose, rates)[0] ** 2)
            )
        moving = p.mass_kg * np.sum(rates[:, :2] ** 2) + p.inertia * np.sum(rates[:, 2] ** 2)
        height = -p.mass_kg * np.sum(pose[:, :2] @ np.asarray(p.gravity_m_s2))
        return np.array([moving / 2, springs, height])

    def gap_rate(self, t_s: float, y: Array) -> Array:
        """Return the rates of the gaps (n-1, 2)."""
        pose, rates, _ = self.links(t_s, y)
        return dense.joint_gaps(self.p, pose, rates)[1]


def centres_of(z: Array, arms: Array) -> Array:
    """Return centres (n, 2) of links with these arms (n, 2) from centre to head, or their rates.

    z begins with those of the centre of mass, then the gaps of all joints.
    """
    n = len(arms)
    steps = arms[:-1] + arms[1:] + z[2 : 2 * n].reshape(n - 1, 2)
    centres = np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])
    return centres + z[:2] - centres.mean(axis=0)


def rk4_step(rate, t_s: float, y: Array, dt_s: float) -> Array:
    """Return y after one classical Runge-Kutta step."""
    k1 = rate(t_s, y)
    k2 = rate(t_s + dt_s / 2, y + dt_s / 2 * k1)
    k3 = rate(t_s + dt_s / 2, y + dt_s / 2 * k2)
    k4 = rate(t_s + dt_s, y + dt_s * k3)
    return y + dt_s / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def slow_run(scene: sn.Scene, start: sn.LinkState) -> dict[str, Array]:
    """Return what simulate would, by the names of Run's fields, recorded at every step.

    For steps that divide a frame and the intervals of a table. At a jump of the drive the forces
    are those just before it.
    """
    slow = SlowScene(scene)
    rows: list[list[Array]] = []

    def note(t: float, y: Array) -> None:
        m, pose, rates = slow.motion(t, y)
        energy = np.concatenate([slow.stores(t, y), y[-4:]])
        rows.append([*pose.T, *rates.T, *m.force_n.T, m.torque_n_m, *m.friction_n.T, energy])

    y, dt = slow.pack(start), scene.dt_s
    if scene.method == "paper":
        slow.held_gap_rate = slow.gap_rate(0.0, y)
    slow.enter(0.0, y)
    note(0.0, y)
    for t in np.arange(scene.steps) * dt:
        slow.enter(t, y)
        before, y = y, rk4_step(slow.rate, t, y, dt)
        if scene.method == "paper":
            slow.held_gap_rate = slow.gap_rate(t, before)
        note(t + dt, y)
    columns = (np.array(part) for part in zip(*rows, strict=True))
    return dict(zip(NAMES, columns, strict=True))
