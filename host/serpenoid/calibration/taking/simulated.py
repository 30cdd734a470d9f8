"""A person in the virtual lab who follows the procedure, with a truth that is known and seeded.

The robot obeys the lab's equations of motion on the belt, not a law of the fit: it yaws and leaves
the belt unless it is steered, and below its least pull the belt carries it away. Everything that is
read goes through instruments that err as the set-up says they may, and now and then the person
misreads, or reads too early.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...lab.belt import Belt
from ...lab.crawl import crawl_speed
from ...lab.person import Habits, Held, Person
from ...lab.robot import pose_of
from ...model.bends import balanced_signs
from ...model.gait import Gait
from ..kinds.declaration import Cells, Field
from ..session import Session, Setup
from .steps import Step
from .world import Truth, between_links_deg, timed_crawl

TURNS, BELT_M = 10, 2.8  # of a belt check
START_M_S = 0.3  # of the belt, where nothing tells better


def _habits(truth: Truth) -> Habits:
    made = Habits(steers=truth.steered, hasty=truth.hasty, let_go_m_s=truth.disturbance_m_s)
    # rails are laid along the belt, and the robot between them
    return replace(made, let_go_rad=0.0, let_go_rad_s=0.0) if truth.guided else made


class SimulatedTreadmill:
    """Do each step of the procedure against a known truth; the same seed does the same.

    run_gait: runs a gait on a board and returns the one that the board made of it, in true seconds.
    """

    def __init__(
        self,
        setup: Setup,
        truth: Truth,
        seed: int = 0,
        run_gait: Callable[[Gait], Gait] | None = None,
    ):
        self.truth = truth
        self._setup = setup
        self._rng = rng = np.random.default_rng(seed)
        self._run_gait = run_gait
        self.robot = truth.robot(setup.robot, rng)
        self.belt = Belt(self.robot, gravity_m_s2=setup.procedure.gravity_m_s2)
        self.belt.guide(truth.guided)
        self._inclinometer_rad = truth.inclinometer_rad(setup)
        self.person = Person(
            self.belt,
            rng,
            _habits(truth),
            truth.display(setup),
        )
        # The deck does not lie level when the treadmill says 0.
        self._deck_rad = math.radians(float(rng.uniform(-0.15, 0.15)))
        self._bent_rad, self._shown_m_s = 0.0, START_M_S
        self._true: dict[str, float | str] = {}
        self._ran: dict[Gait, tuple[float, float]] = {}  # true rate and speed
        self.misread = 0

    def answer(self, step: Step, session: Session) -> Cells | None:
        """Do a step as a person would."""
        read: Cells | None = getattr(self, f"_{step.kind}")(step)
        self._true = dict(read or {})
        return None if read is None else self._typed(step, read)

    def look_again(
        self, step: Step, doubtful: Sequence[tuple[Field, tuple[float, float]]], cells: Cells
    ) -> Cells:
        """Read again what is doubted, with care."""
        return self._bend(step) if step.kind == "bend" else self._true

    def _normal(self, sigma: float) -> float:
        return float(self._rng.normal()) * sigma

    def _shown_deg(self, incline_rad: float) -> float:
        return round(math.degrees(self._inclinometer_rad.shows(incline_rad, self._rng)), 4)

    def _zero(self, step: Step) -> Cells:
        slope_rad = math.radians(float(self._rng.uniform(-0.4, 0.4)))
        return {
            "incline_deg": self._shown_deg(slope_rad),
            "reversed_deg": self._shown_deg(-slope_rad),
        }

    def _straight(self, step: Step) -> Cells:
        self._pose(0.0, step.facing)
        return {}

    def _pose(self, bent_rad: float, facing: str) -> None:
        """Have the board put the robot in a pose, and lay it on the belt."""
        links = self._setup.robot.links
        zigzag = self._setup.procedure.bend == "zigzag"
        signs = [(-1) ** k for k in range(links)] if zigzag else balanced_signs(links)
        self._bent_rad, self.person.facing = bent_rad, facing
        self.belt.pose(pose_of(signs, bent_rad))

    def _bend(self, step: Step) -> Cells:
        """Bend as planned; lay the protractor on the joints at both ends."""
        self._pose(math.radians(step.lambda_deg), step.facing)
        # of each end, so that half the mean of both errs by what is stated of the bend
        scatter = 2 * math.sqrt(2) * self._setup.uncertainty.lambda_sigma_rad
        ends = self.robot.ends_rad(self.belt.pose_rad, scatter, self._rng)
        return {"between_links_deg": between_links_deg(ends)}

    def _station(self, step: Step) -> Cells | None:
        """Set the nearest incline, find the belt speed that holds, wait, read what is left."""
        steps = self._setup.treadmill
        aim = math.radians(step.incline_deg) - self.truth.incline_zero_rad - self._deck_rad
        grade_step = steps.incline_step_rad * self.truth.incline_scale
        grade = round(math.tan(aim) / grade_step) * grade_step
        incline_rad = math.atan(grade) + self._deck_rad
        self.belt.tilt(incline_rad)
        self.person.facing = step.facing
        held = self._read(step)
        if held is None or held.belt_shown_m_s - held.drift_m_s <= 0.0:
            return None
        self._shown_m_s = held.belt_shown_m_s
        return {
            "incline_deg": self._shown_deg(incline_rad),
            "belt_speed_m_s": round(held.belt_shown_m_s, 5),
            "drift_m_s": round(held.drift_m_s, 3),
            "turned_deg": round(math.degrees(held.turned_rad), 1),
            "offset_deg": round(math.degrees(held.offset_rad), 3),
            "waited_s": round(held.waited_s, 1),
            "places": ",".join(f"{t:.3f}:{y:.4f}" for t, y in held.places),
        }

    def _read(self, step: Step) -> Held | None:
        """Hold the robot until it settles; or only film how it drifts, where that is the plan."""
        guess_m_s = self._guess_m_s(step)
        if self._bent_rad and self.truth.short_s:
            return self.person.film(guess_m_s, self.truth.short_s)
        return self.person.hold(guess_m_s, step.settle_s)

    def _belt(self, step: Step) -> Cells:
        """Time a mark on the belt over ten turns."""
        shown = (
            round(0.5 / self._setup.treadmill.belt_step_m_s) * self._setup.treadmill.belt_step_m_s
        )
        watch, way_m = self._setup.stopwatch, TURNS * BELT_M
        duration = way_m / (shown * self.truth.belt_scale) + self._normal(watch.time_sigma_s)
        return {
            "belt_speed_m_s": round(shown, 5),
            "distance_m": round(way_m + self._normal(watch.distance_sigma_m), 3),
            "duration_s": round(duration, 2),
        }

    def _guess_m_s(self, step: Step) -> float:
        """Return where a person begins: what the dialogue lets expect, else where the belt was."""
        likely = next((f.likely for f in step.fields if f.column == "belt_speed_m_s"), None)
        return sum(likely) / 2 if likely is not None else self._shown_m_s

    def _gait(self, step: Step) -> Cells:
        gait = step.gait
        assert gait is not None  # a gait's step has one
        if gait not in self._ran:
            made = gait if self._run_gait is None else self._run_gait(gait)
            true = replace(made, alpha_rad=made.alpha_rad * self.truth.amplitude)
            self._ran[gait] = made.omega_rad_s, crawl_speed(self.robot, true)
        omega, speed = self._ran[gait]
        return timed_crawl(speed, self._setup.stopwatch, self._rng)[0] | {"omega_rad_s": omega}

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
