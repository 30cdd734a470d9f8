"""A person in the virtual lab who follows the procedure, with a truth that is known and seeded.

The robot obeys the lab's equations of motion, not a law of the fit: on a belt it yaws and leaves it
unless it is steered, and below its least pull the belt carries it away; on a floor who pushes it
lets go a little crooked. Everything that is read goes through instruments that err as the set-up
says they may, and now and then the person misreads, or reads too early.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..lab.belt import Belt
from ..lab.crawl import crawl_speed, filmed_crawl
from ..lab.floor import Floor, Push, Track
from ..lab.person import Habits, Held, Person
from ..lab.recording import Camera, film, to_rest
from ..lab.robot import pose_of
from ..model.bends import bend_signs
from ..model.gait import Gait
from ..session.declaration import Cells
from ..session.filmed_crawl import crawl_cells
from ..session.session import Session
from ..session.settings import Setup
from ..session.station import slips
from ..session.track import Floats
from .steps import Doubts, Step, Tracked
from .track_look import look_at
from .world import Truth

TURNS, BELT_M, CHECKED_M_S = 10, 2.8, 0.5  # of a belt check
START_M_S = 0.3  # of the belt, where nothing tells better
RUN_M, RUN_S = 1.0, 40.0  # a gait run: so far, or so long at most
SPEED, SPEED_SIGMA = 0.9, 0.12  # m/s, of pushes, and how they scatter, relative
CROOKED_RAD, SPIN_RAD_S = 0.015, 0.06
SPEED_OFF, GAIN_OFF = 0.002, 0.002  # of a filmed crawl: its scale, each joint's amplitude
TRIES = 6  # of a push, until somebody gives up
# What a person on a floor takes, s: to turn the robot round, push it and take the film in; to bend
# it and lay the protractor on; to start a gait and lay the tape.
PUSH_S, BEND_S, GAIT_S = 40.0, 90.0, 60.0
# Error of each end under a protractor, over what is stated of the bend: half the mean of both errs
# by that at a treadmill, by half of it on a floor, where there is room and light.
ENDS = {"treadmill": 2 * math.sqrt(2), "floor": math.sqrt(2)}


def _habits(truth: Truth) -> Habits:
    habits = Habits(hasty=truth.hasty, let_go_m_s=truth.disturbance_m_s)
    # rails are laid along the belt, and the robot between them
    return replace(habits, let_go_rad=0.0, let_go_rad_s=0.0) if truth.guided else habits


class SimulatedPerson:
    """Do each step of the procedure against a known truth; the same seed does the same.

    It answers with what a person could read, never with a truth: for each kind of step
    (`Step.kind`) the numbers of `step.fields`, in the columns' units. zero (incline_deg,
    reversed_deg), bend (between_links_deg, between the last two links at an end of a robot bent as
    `step.bend` says), station (incline_deg, belt_speed_m_s, drift_m_s, turned_deg, offset_deg and
    waited_s), belt (belt_speed_m_s, distance_m, duration_s of a mark on the belt), gait
    (distance_m, duration_s, omega_rad_s; or a `Tracked` of kind `video`), push (distance_m,
    duration_s, or a `Tracked` with the track of a push); straight has none. A person who types
    takes the same steps (`person.dialogue`).

    run_gait: runs a gait on a board and returns the one that the board made of it, in true seconds.
    t_s: what a person on a floor has needed so far.
    """

    def __init__(
        self,
        setup: Setup,
        truth: Truth,
        seed: int = 0,
        run_gait: Callable[[Gait], Gait] = lambda gait: gait,
    ):
        self.setup, self.truth, self.rng = setup, truth, np.random.default_rng(seed)
        self.robot = truth.robot(setup.robot, self.rng)
        self._floor = Floor(self.robot, truth.slope_rad, truth.across_rad)
        self._speeds = dict[tuple[Gait, tuple[float, float]], float]()
        self.t_s, self.misread = 0.0, 0
        self._run_gait = lru_cache(run_gait)
        self._belt_run = Belt(self.robot, gravity_m_s2=setup.laboratory.gravity_m_s2)
        self._belt_run.guide(truth.guided)
        self._inclinometer_rad = truth.inclinometer_rad(setup)
        self.person = Person(self._belt_run, self.rng, _habits(truth), truth.display(setup))
        self._on_floor = setup.plan.on == "floor"
        # The deck does not lie level when the treadmill says 0.
        deck_deg = 0.0 if self._on_floor else float(self.rng.uniform(-0.15, 0.15))
        self._deck_rad = math.radians(deck_deg)
        self._shown_m_s = START_M_S
        self._true: Cells = {}

    def answer(self, step: Step, session: Session) -> Cells | None:
        """Do a step as a person would; return None if it cannot be done."""
        read: Cells | None = getattr(self, f"_{step.kind}")(step)
        self._true = read or {}
        return None if read is None else self._typed(step, read)

    def look_again(self, step: Step, doubtful: Doubts, cells: Cells) -> Cells:
        """Read again what is doubted, with care; on a floor what was measured is over."""
        again = step.kind == "bend" and not self._on_floor
        return self._bend(step) if again else self._true

    def _shown_deg(self, incline_rad: float) -> float:
        return round(math.degrees(self._inclinometer_rad.shows(incline_rad, self.rng)), 4)

    def _zero(self, step: Step) -> Cells:
        slope_rad = math.radians(float(self.rng.uniform(-0.4, 0.4)))
        return {
            "incline_deg": self._shown_deg(slope_rad),
            "reversed_deg": self._shown_deg(-slope_rad),
        }

    def _straight(self, step: Step) -> Cells:
        """Have the board put the robot in a step's pose, and lay it on the belt or the floor."""
        self.t_s += BEND_S
        signs = bend_signs(self.setup.plan.bend, self.setup.robot.links)
        self._pose_rad = pose_of(signs, math.radians(step.lambda_deg))
        self._belt_run.pose(self._pose_rad)
        return {}

    def _bend(self, step: Step) -> Cells:
        """Bend as planned; lay the protractor on the joints at both ends."""
        self._straight(step)
        off_rad = ENDS[self.setup.plan.on] * self.setup.instruments.lambda_sigma_rad
        shown_deg = self.robot.protractor_deg(self._pose_rad, off_rad, self.rng)
        return {"between_links_deg": round(sum(shown_deg) / 2, 1)}

    def _station(self, step: Step) -> Cells | None:
        """Set the nearest incline, find the belt speed that holds, wait, read what is left."""
        steps = self.setup.instruments
        aim = math.radians(step.incline_deg) - self.truth.incline_zero_rad - self._deck_rad
        grade_step = steps.incline_step_rad * self.truth.incline_scale
        grade = round(math.tan(aim) / grade_step) * grade_step
        incline_rad = math.atan(grade) + self._deck_rad
        self._belt_run.tilt(incline_rad)
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
        likely = next((f.likely for f in step.fields if f.column == "belt_speed_m_s"), None)
        guess_m_s = sum(likely) / 2 if likely is not None else self._shown_m_s
        if step.lambda_deg and self.truth.short_s:
            return self.person.film(guess_m_s, self.truth.short_s)
        return self.person.hold(guess_m_s, step.settle_s)

    def _belt(self, step: Step) -> Cells:
        """Time a mark on the belt over ten turns."""
        step_m_s, watch = self.setup.instruments.belt_speed_step_m_s, self.setup.instruments
        shown, way_m = round(CHECKED_M_S / step_m_s) * step_m_s, TURNS * BELT_M
        off_s = self.normal(watch.time_sigma_s)
        return {
            "belt_speed_m_s": round(shown, 5),
            "distance_m": round(way_m + self.normal(watch.distance_sigma_m), 3),
            "duration_s": round(way_m / (shown * self.truth.belt_scale) + off_s, 2),
        }

    def _push(self, step: Step) -> Cells | None:
        """Push until a push is as it should be; return its track, or way and time to rest."""
        for _ in range(TRIES):
            self.t_s += PUSH_S
            track = self.push(step)
            if self.truth.camera is None:
                return self.tape(track)
            samples = self.film(track, self.truth.camera)
            slipping = slips(step.bend, step.lambda_deg, self.setup.robot.links)
            look = look_at(*samples.T, slips=slipping)
            if not look.doubts:
                return Tracked({**look.cells(), "by": "film"}, samples)
        return None

    def _gait(self, step: Step) -> Cells:
        """Run a gait, and film it on a floor; else time it between two marks."""
        assert step.gait is not None  # a gait's step has one
        gait = self._run_gait(step.gait)
        self.t_s += GAIT_S
        if self._on_floor and self.truth.camera is not None:
            self.t_s += RUN_S
            rows = self.film_crawl(step, gait, self.truth.camera)
            return Tracked({**crawl_cells(rows, gait), "film_sha256": "simulated"}, rows, "video")
        read, duration_s = self.time_crawl(step, gait)
        self.t_s += duration_s
        return read | {"omega_rad_s": gait.omega_rad_s}

    def _typed(self, step: Step, read: Cells) -> Cells:
        """Return what is typed: now and then a figure is wrong."""
        if step.kind != "station" or self.rng.uniform() >= self.truth.misreads:
            return read
        self.misread += 1
        if self.rng.uniform() < 0.5:
            return {**read, "incline_deg": round(float(read["incline_deg"]) + 1.0, 4)}
        return {**read, "belt_speed_m_s": round(float(read["belt_speed_m_s"]) * 3.6, 5)}  # km/h

    def normal(self, sigma: float) -> float:
        """Return an error drawn."""
        return float(self.rng.normal()) * sigma

    def push(self, step: Step, speed_m_s: float = SPEED) -> Track:
        """Push the robot the way that a step says, as a hand does: about so fast, not straight."""
        direction = 0.0 if step.cells["way"] == "there" else math.pi
        speed_m_s *= max(1.0 + self.normal(SPEED_SIGMA), 0.3)
        crooked_rad, spin_rad_s = self.normal(CROOKED_RAD), self.normal(SPIN_RAD_S)
        made = Push(speed_m_s, direction, crooked_rad, spin_rad_s)
        return self._floor.push(self._pose_rad, made)

    def film(self, track: Track, camera: Camera) -> Floats:
        """Return what a film shows of a push: t_s, x_m, y_m in rows."""
        return film(track, replace(camera, scale=self.truth.film_scale), self.rng)[:, :3]

    def tape(self, track: Track) -> dict[str, float]:
        """Return what tape and watch say of a push, and by how much it turned."""
        way_m, time_s = to_rest(track, self.rng)
        turned_deg = round(math.degrees(track.turned_rad))
        return {"distance_m": way_m, "duration_s": time_s, "turned_deg": turned_deg}

    def time_crawl(self, step: Step, gait: Gait) -> tuple[dict[str, float], float]:
        """Return what tape and watch say of a step's crawl, and how long it took, s."""
        key = gait, self._slopes(step)
        if key not in self._speeds:
            rises, falls = key[1]
            self._speeds[key] = crawl_speed(
                self.robot, self._made(gait), slope_rad=rises, across_rad=falls
            )
        speed_m_s, watch = self._speeds[key], self.setup.instruments
        distance = min(RUN_M, speed_m_s * RUN_S)
        duration = distance / speed_m_s if speed_m_s > 0.0 else RUN_S
        duration += self.normal(watch.time_sigma_s)
        measured = max(distance + self.normal(watch.distance_sigma_m), 0.0)
        read = {"distance_m": round(measured, 3), "duration_s": round(max(duration, 0.1), 2)}
        return read, duration

    def film_crawl(self, step: Step, gait: Gait, camera: Camera) -> Floats:
        """Return what is measured in a film of a crawl, its scale and joints' gains a little off.

        Rows as of `filmed_crawl`.
        """
        off = replace(camera, scale=1.0 + self.normal(SPEED_OFF))
        rows = filmed_crawl(self.robot, self._made(gait), off, self.rng, *self._slopes(step))
        rows[:, 4:] *= 1.0 + GAIN_OFF * self.rng.normal(size=rows.shape[1] - 4)
        return rows

    def _made(self, gait: Gait) -> Gait:
        return replace(gait, alpha_rad=gait.alpha_rad * self.truth.amplitude)

    def _slopes(self, step: Step) -> tuple[float, float]:
        """Return by what the floor rises ahead of a step's crawl, and falls to its left."""
        side = {"there": 1.0, "back": -1.0}.get(str(step.cells.get("way", "")), 0.0)
        return -side * self.truth.slope_rad, side * self.truth.across_rad
