"""A treadmill, a robot and a person that are not there, with a truth that is known and seeded.

The robot on the belt obeys m u' = F(slip) - m g sin(gamma) downhill, with friction summed over
its links; friction at rest is set-valued, so below the least pull the wheels stick and the belt
carries the robot away: no station. Everything a person reads goes through instruments that err as
the set-up says they may, and now and then the person misreads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...model.bends import balanced_signs
from ...model.gait import Gait
from ...model.ground import Ground
from ...model.robot import Robot
from ..kinds.declaration import Cells, Field
from ..session import Session, Setup
from .steps import Step

GaitSpeed = Callable[[Robot, Ground, Gait], float]
LOST_M_S = 0.12  # of drift: the robot is off the belt before it has settled
CREEP_M_S = 0.03  # of slip: below it wheels stick and slip by turns
RUN_M, RUN_S = 1.0, 40.0  # a gait run: so far, or so long at most


@dataclass(frozen=True)
class Truth:
    """What a person at the treadmill does not know.

    ground: of the whole snake. incline_zero_rad: what the inclinometer shows where it is level.
    belt_scale: true belt speed over shown. incline_scale: the treadmill's true steps of grade over
    those stated. joint_sigma_rad: of one bend as it comes out, before
    the protractor tells. disturbance_m_s: of the robot when it is let go. misreads: share of
    readings that are typed wrong. amplitude: of the joints in a gait, true over commanded.
    """

    ground: Ground
    incline_zero_rad: float = 0.0
    belt_scale: float = 1.0
    incline_scale: float = 1.0
    joint_sigma_rad: float = math.radians(1.0)
    disturbance_m_s: float = 0.05
    misreads: float = 0.0
    amplitude: float = 1.0


def drawn_truth(setup: Setup, ground: Ground, rng: np.random.Generator) -> Truth:
    """Draw the errors that all readings of a session share, as the set-up says they may be."""
    zero_rad = float(rng.normal()) * setup.uncertainty.incline_zero_sigma_rad
    return Truth(ground, incline_zero_rad=zero_rad)


class SimulatedTreadmill:
    """Do each step of the procedure against a known truth; the same seed does the same.

    gait_speed: the true speed of a gait on ground per link, m/s; the exact model's unless given.
    run_gait: runs a gait on a board and returns the one that the board made of it, in true seconds.
    """

    def __init__(
        self,
        setup: Setup,
        truth: Truth,
        seed: int = 0,
        gait_speed: GaitSpeed | None = None,
        run_gait: Callable[[Gait], Gait] | None = None,
    ):
        self.truth = truth
        self._setup = setup
        self._rng = np.random.default_rng(seed)
        self._gait_speed = gait_speed or exact_speed
        self._run_gait = run_gait
        self._lambda_rad, self._facing = 0.0, "down"
        # The deck does not lie level when the treadmill says 0.
        self._deck_rad = math.radians(float(self._rng.uniform(-0.15, 0.15)))
        self._true: dict[str, float | str] = {}
        self._ran: dict[Gait, tuple[float, float]] = {}  # true rate and speed
        self.misread = 0

    def answer(self, step: Step, session: Session) -> Cells | None:
        """Do a step as a person would."""
        read = {
            "zero": self._zero, "straight": self._straight, "bend": self._bend,
            "station": self._station, "gait": self._gait,
        }[step.kind](step)  # fmt: skip
        self._true = dict(read or {})
        return None if read is None else self._typed(step, read)

    def look_again(
        self, step: Step, doubtful: Sequence[tuple[Field, tuple[float, float]]], cells: Cells
    ) -> Cells:
        """Read again what is doubted, with care; bend again what came out too far off."""
        return self._bend(step) if step.kind == "bend" else self._true

    def true_slip_m_s(
        self, incline_rad: float, lambda_rad: float, facing: str = "down"
    ) -> float | None:
        """Return the slip at which friction balances the pull; None where the wheels stick."""
        slope, dry_n = self._pull(lambda_rad, facing)
        slip = (self._setup.weight_n * math.sin(incline_rad) - dry_n) / slope
        return slip if slip > 0.0 else None

    def _pull(self, lambda_rad: float, facing: str) -> tuple[float, float]:
        """Return A and B: friction along the belt is A v + B, summed link by link."""
        ground, links = self.truth.ground, self._setup.robot.links
        zigzag = self._setup.procedure.bend == "zigzag"
        signs = (1,) * links if zigzag else balanced_signs(links)
        ct, ft0 = (
            (ground.ct_backward, ground.ft0_backward) if facing == "up"
            else (ground.ct_forward, ground.ft0_forward)
        )  # fmt: skip
        turned = [abs(sign) * lambda_rad for sign in signs]
        slope = sum(ct * math.cos(x) ** 2 + ground.cn * math.sin(x) ** 2 for x in turned)
        dry = sum(ft0 * math.cos(x) + ground.fn0 * math.sin(x) for x in turned)
        return slope / links, dry / links

    def _normal(self, sigma: float) -> float:
        return float(self._rng.normal()) * sigma

    def _shown_deg(self, incline_rad: float) -> float:
        """Return what the inclinometer shows: its zero on top, in its steps."""
        step = self._setup.uncertainty.incline_sigma_rad * math.sqrt(12)
        shown = round((incline_rad + self.truth.incline_zero_rad) / step) * step
        return round(math.degrees(shown), 4)

    def _zero(self, step: Step) -> Cells:
        slope_rad = math.radians(float(self._rng.uniform(-0.4, 0.4)))
        return {
            "incline_deg": self._shown_deg(slope_rad),
            "reversed_deg": self._shown_deg(-slope_rad),
        }

    def _straight(self, step: Step) -> Cells:
        self._lambda_rad, self._facing = 0.0, step.facing
        return {}

    def _bend(self, step: Step) -> Cells:
        bent = math.radians(step.lambda_deg) + self._normal(self.truth.joint_sigma_rad)
        self._lambda_rad, self._facing = max(bent, math.radians(1.0)), step.facing
        seen = self._lambda_rad + self._normal(self._setup.uncertainty.lambda_sigma_rad)
        return {"between_links_deg": round(180.0 - 2 * math.degrees(seen), 1)}

    def _station(self, step: Step) -> Cells | None:
        """Set the nearest incline, find the belt step that holds best, wait, read what is left."""
        setup = self._setup
        steps = setup.treadmill
        aim = math.tan(
            math.radians(step.incline_deg) - self.truth.incline_zero_rad - self._deck_rad
        )
        grade_step = steps.incline_step_rad * self.truth.incline_scale
        grade = round(aim / grade_step) * grade_step
        incline_rad = math.atan(grade) + self._deck_rad
        slip = self.true_slip_m_s(incline_rad, self._lambda_rad, self._facing)
        if slip is None:
            return None
        belt = max(
            round(slip / self.truth.belt_scale / steps.belt_step_m_s) * steps.belt_step_m_s,
            steps.belt_least_m_s, steps.belt_step_m_s,
        )  # fmt: skip
        drift = belt * self.truth.belt_scale - slip
        if abs(drift) > LOST_M_S:
            return None
        unsettled = self._normal(self.truth.disturbance_m_s) * self._left(step)
        jerks = self._normal(0.01) if slip < CREEP_M_S else 0.0
        noise = self._normal(setup.uncertainty.belt_speed_sigma_m_s)
        drift_shown = round(drift + unsettled + jerks + noise, 3)
        if belt - drift_shown <= 0.0:
            return None
        return {
            "incline_deg": self._shown_deg(incline_rad),
            "belt_speed_m_s": round(belt, 5),
            "drift_m_s": drift_shown,
        }

    def _left(self, step: Step) -> float:
        """Return the share of a disturbance that is left when a station is read."""
        slope, _ = self._pull(self._lambda_rad, self._facing)
        mass_kg = self._setup.robot.links * self._setup.robot.link_mass_kg
        return math.exp(-step.settle_s * slope / mass_kg)

    def _gait(self, step: Step) -> Cells:
        gait = step.gait
        assert gait is not None  # a gait's step has one
        if gait not in self._ran:
            made = gait if self._run_gait is None else self._run_gait(gait)
            true = replace(made, alpha_rad=made.alpha_rad * self.truth.amplitude)
            robot, ground = self._setup.robot, self.truth.ground
            per_link = Ground.whole_body(robot.links, ground.ct, ground.cn, ground.ft0, ground.fn0)
            self._ran[gait] = made.omega_rad_s, self._gait_speed(robot, per_link, true)
        (omega, speed), watch = self._ran[gait], self._setup.stopwatch
        distance = min(RUN_M, speed * RUN_S)
        duration = (distance / speed if speed > 0.0 else RUN_S) + self._normal(watch.time_sigma_s)
        measured = max(distance + self._normal(watch.distance_sigma_m), 0.0)
        return {
            "distance_m": round(measured, 3),
            "duration_s": round(max(duration, 0.1), 2),
            "omega_rad_s": omega,
        }

    def _typed(self, step: Step, read: Mapping[str, float | str]) -> Cells:
        """Return what is typed: now and then a figure is wrong."""
        typed = dict(read)
        if step.kind == "station" and self._rng.uniform() < self.truth.misreads:
            self.misread += 1
            if self._rng.uniform() < 0.5:
                typed["incline_deg"] = round(float(typed["incline_deg"]) + 1.0, 4)
            else:
                typed["belt_speed_m_s"] = round(float(typed["belt_speed_m_s"]) * 3.6, 5)  # km/h
        return typed


def exact_speed(robot: Robot, ground: Ground, gait: Gait) -> float:
    """Return the exact model's steady speed of a gait, m/s."""
    from ...periodic.steady import steady_gait

    return steady_gait(robot, ground, gait, rtol=1e-4, powers=False).speed_m_s
