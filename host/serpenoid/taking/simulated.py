"""A person in the virtual lab who follows the procedure, with a truth that is known and seeded.

The robot obeys the lab's equations of motion, not a law of the fit: on a belt it yaws and leaves it
unless it is steered, and below its least pull the belt carries it away; on a floor who pushes it
lets go a little crooked. Everything that is read goes through instruments that err as the set-up
says they may.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from ..base.errors import NotConverged
from ..base.sines import basis
from ..base.vectors import Array
from ..lab.belt import Belt
from ..lab.crawl import crawl_speed, filmed_crawl
from ..lab.floor import Floor, Push
from ..lab.instruments import Instrument
from ..lab.person import Display, Person
from ..lab.recording import Camera, film
from ..lab.robot import LabRobot, pose_of
from ..model.bends import bend_signs
from ..model.drives import Servo
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..session.declaration import Cells
from ..session.journal import Journal
from ..session.session import Session
from ..session.settings import Setup
from ..session.station import slips
from .procedure import Step, Tracked, next_step, record_step
from .track_look import look_at

FILM_ERROR = 0.002  # relative error of a crawl's scale and of each joint's amplitude


@dataclass(frozen=True)
class Truth:
    """What a person at a treadmill or on a floor does not know.

    Of the robot: ground, of the whole snake. mass_scale: its true mass over the one weighed.
    joint_sigma_rad: of what each joint stands off its set-point, for good. rolling_kg: inertia of
    the wheels (`lab.robot`). amplitude: of the joints in a gait, true over commanded. servo: what
    moves them in a gait; None: they follow it.

    Of a treadmill: incline_zero_rad: what the inclinometer shows where it is level. belt_scale:
    true belt speed over shown. incline_scale: its true steps of grade over those stated.

    Of a floor: slope_rad, across_rad: by what it falls towards "there" and to the left of it.
    film_scale: lengths in films over true. camera: what films.
    """

    ground: Ground
    mass_scale: float = 1.0
    joint_sigma_rad: float = math.radians(0.5)
    rolling_kg: float = 0.0
    amplitude: float = 1.0
    servo: Servo | None = None
    incline_zero_rad: float = 0.0
    belt_scale: float = 1.0
    incline_scale: float = 1.0
    slope_rad: float = 0.0
    across_rad: float = 0.0
    film_scale: float = 1.0
    camera: Camera = field(default_factory=Camera)

    def robot(self, body: Robot, rng: np.random.Generator) -> LabRobot:
        """Return the robot as it truly is, its joint errors drawn."""
        mass_kg = body.link_mass_kg * self.mass_scale
        inertia = body.inertia_kg_m2 * self.mass_scale
        heavy = replace(body, link_mass_kg=mass_kg, link_inertia_kg_m2=inertia)
        robot = LabRobot.whole_body(
            heavy, self.ground, rolling_kg=self.rolling_kg, servo=self.servo
        )
        return robot.drawn(rng, self.joint_sigma_rad)


def wheel_inertia_kg(setup: Setup, sigmas: float = 0.0) -> float:
    """Return J / r^2 of all wheels of a set-up, kg; sigmas: by which it is off the usual."""
    wheels_kg = setup.robot_table.wheels_kg
    if wheels_kg is not None:
        return max((0.75 + 0.15 * sigmas) * wheels_kg, 0.0)
    mass_kg = setup.robot.links * setup.robot.link_mass_kg
    return max((0.045 + 0.03 * sigmas) * mass_kg, 0.0)


class SimulatedPerson:
    """Do each step of the procedure against a known truth; the same seed does the same.

    It answers with what a person could read, never with a truth.
    """

    def __init__(self, setup: Setup, truth: Truth, seed: int = 0):
        self.setup, self.truth, self.rng = setup, truth, np.random.default_rng(seed)
        self.robot = truth.robot(setup.robot, self.rng)
        self._floor = Floor(self.robot, truth.slope_rad, truth.across_rad)
        self._treadmill = Belt(self.robot, gravity_m_s2=setup.laboratory.gravity_m_s2)
        tools = setup.instruments
        display = Display(
            tools.belt_speed_step_m_s,
            truth.belt_scale,
            tools.belt_speed_least_m_s,
            tools.belt_speed_sigma_m_s,
        )
        self._person = Person(self._treadmill, self.rng, display=display)
        # The deck does not lie level when the treadmill says 0.
        self._deck_rad = math.radians(float(self.rng.uniform(-0.15, 0.15)))
        self._shown_m_s = 0.3  # first guess
        self._crawl_speed = lru_cache(crawl_speed)

    def answer(self, step: Step) -> Cells | None:
        """Do a step as a person would; return what is read, None if it cannot be done."""
        return getattr(self, f"_{step.kind}")(step)  # type: ignore[no-any-return]

    def _shown_deg(self, incline_rad: float) -> float:
        step_rad = self.setup.instruments.incline_sigma_rad * math.sqrt(12)
        inclinometer = Instrument(self.truth.incline_zero_rad, step=step_rad)
        return round(math.degrees(inclinometer.shows(incline_rad, self.rng)), 4)

    def _zero(self, step: Step) -> Cells:
        slope_rad = math.radians(float(self.rng.uniform(-0.4, 0.4)))
        shown = self._shown_deg(slope_rad), self._shown_deg(-slope_rad)
        return dict(zip(("incline_deg", "reversed_deg"), shown, strict=True))

    def _straight(self, step: Step) -> Cells:
        """Have the board put the robot in a step's pose, and lay it on the belt or the floor."""
        signs = bend_signs(self.setup.plan.bend, self.setup.robot.links)
        self._pose_rad = pose_of(signs, math.radians(step.lambda_deg))
        self._treadmill.pose(self._pose_rad)
        return {}

    def _bend(self, step: Step) -> Cells:
        """Bend as planned; lay the protractor on the joints at both ends."""
        self._straight(step)
        # At a treadmill the bend errs by twice what half the mean of both ends does; a floor has
        # room and light.
        factor = math.sqrt(2) * (1.0 if self.setup.plan.on == "floor" else 2.0)
        sigma_rad = factor * self.setup.instruments.lambda_sigma_rad
        shown_deg = self.robot.protractor_deg(self._pose_rad, sigma_rad, self.rng)
        return {"between_links_deg": round(sum(shown_deg) / 2, 1)}

    def _station(self, step: Step) -> Cells | None:
        """Set the nearest incline, find the belt speed that holds, wait, read what is left."""
        truth = self.truth
        grade_step = self.setup.instruments.incline_step_rad * truth.incline_scale
        wanted_rad = math.radians(step.incline_deg) - truth.incline_zero_rad - self._deck_rad
        grade = round(math.tan(wanted_rad) / grade_step) * grade_step
        incline_rad = math.atan(grade) + self._deck_rad
        self._treadmill.tilt(incline_rad)
        station = self._person.hold(self._shown_m_s, step.settle_s)
        if station is None or station.belt_shown_m_s <= station.drift_m_s:
            return None
        self._shown_m_s = station.belt_shown_m_s
        return {
            "incline_deg": self._shown_deg(incline_rad),
            "belt_speed_m_s": round(station.belt_shown_m_s, 5),
            "drift_m_s": round(station.drift_m_s, 3),
            "turned_deg": round(math.degrees(station.turned_rad), 1),
            "offset_deg": round(math.degrees(station.offset_rad), 3),
        }

    def _belt(self, step: Step) -> Cells:
        shown_m_s, turns_m = 0.5, 28.0  # ten turns
        return {"belt_speed_m_s": shown_m_s} | self._timed(
            turns_m, shown_m_s * self.truth.belt_scale
        )

    def _timed(self, distance_m: float, speed_m_s: float) -> dict[str, float]:
        """Return a distance and the time for it, by tape and stopwatch."""
        tools = self.setup.instruments
        way_m = distance_m + self._error(tools.distance_sigma_m)
        time_s = distance_m / speed_m_s + self._error(tools.time_sigma_s)
        return {"distance_m": round(max(way_m, 0.0), 3), "duration_s": round(max(time_s, 0.1), 2)}

    def _push(self, step: Step) -> Cells | None:
        """Push until a push is as it should be; return its track."""
        direction_rad = 0.0 if step.cells["way"] == "there" else math.pi
        camera, plan = self.truth.camera, self.setup.plan
        slipping = slips(plan.bend, step.lambda_deg, self.setup.robot.links)
        for _ in range(6):  # until somebody gives up
            speed_m_s = 0.9 * max(1.0 + self._error(0.12), 0.3)
            crooked = self._error(0.015), self._error(0.06)  # direction, rad, and turning, rad/s
            track = self._floor.push(self._pose_rad, Push(speed_m_s, direction_rad, *crooked))
            rows = film(track, replace(camera, scale=self.truth.film_scale), self.rng)[:, :3]
            look = look_at(rows, slips=slipping)
            if not look.doubts:
                return Tracked({**look.cells, "by": "film"}, rows)
        return None

    def _gait(self, step: Step) -> Cells:
        """Run a gait, and film it on a floor; else time it between two marks."""
        assert step.gait is not None  # a gait's step has one
        gait = step.gait
        swinging = replace(gait, alpha_rad=gait.alpha_rad * self.truth.amplitude)
        side = {"there": 1.0, "back": -1.0}.get(str(step.cells.get("way", "")), 0.0)
        slopes = -side * self.truth.slope_rad, side * self.truth.across_rad
        if self.setup.plan.on == "floor":
            camera = replace(self.truth.camera, scale=1.0 + self._error(FILM_ERROR))
            rows = filmed_crawl(self.robot, swinging, camera, self.rng, *slopes)
            rows[:, 4:] *= 1.0 + FILM_ERROR * self.rng.normal(size=rows.shape[1] - 4)
            return Tracked(crawl_cells(rows, gait), rows, "video")
        rises = {"slope_rad": slopes[0], "across_rad": slopes[1]}
        speed_m_s = self._crawl_speed(self.robot, swinging, **rises)
        longest_m, longest_s = 1.0, 40.0
        return self._timed(min(longest_m, speed_m_s * longest_s), max(speed_m_s, 1e-6))

    def _error(self, sigma: float) -> float:
        return float(self.rng.normal()) * sigma


def take_all(
    record: Journal,
    person: SimulatedPerson,
    tell: Callable[[str], object] = lambda text: None,
) -> Session:
    """Take every step that is left of a session; return the session. Raises NotConverged.

    tell: is called with each step that is done or left out, in words.
    """
    posed_deg: float | None = None
    most_steps = 1000
    for _ in range(most_steps):
        step = next_step(record.session, posed_deg)
        if step.kind == "done":
            return record.session
        cells = person.answer(step)
        if cells is None:
            record.event("skip", detail=step.key)
            tell(f"left out: {step.key}")
        else:
            record_step(record, step, cells)
            posed_deg = step.posed_deg
            tell(f"done: {step.key}")
    raise NotConverged(
        f"{most_steps} steps and no end: does the treadmill's incline rise at all? Look at the "
        "readings with `serpenoid calibrate status`"
    )


def crawl_cells(rows: Array, gait: Gait) -> Cells:
    """Return what a film of a gait at its own rate tells: the cells of a `video` reading.

    rows: t_s, x_m, y_m, heading_rad and every joint's angle, rad.
    """
    t_s, angles = rows[:, 0], rows[:, 4:]
    waves = basis(t_s, gait.omega_rad_s, harmonics=1)
    sines = np.linalg.lstsq(waves, angles, rcond=None)[0]
    amplitude_sigma_rad = (angles - waves @ sines).std() * math.sqrt(2 / len(t_s))
    joints = np.arange(angles.shape[1])
    phasors = (sines[2] + 1j * sines[1]) * np.exp(-1j * gait.beta_rad * joints)
    shifts = np.degrees(np.angle(phasors / phasors.sum()))
    begins = t_s <= t_s[-1] - gait.period_s
    chords = [np.interp(t_s + gait.period_s, t_s, way) - way for way in rows[:, 1:3].T]
    speeds = np.hypot(*chords)[begins] / gait.period_s
    cycles = max(np.ptp(t_s) / gait.period_s - 1.0, 0.5)
    speed_m_s = float(speeds.mean())
    return {
        "offset_deg": math.degrees(float(sines[0].mean())),
        "speed_m_s": speed_m_s,
        "speed_sigma_m_s": math.hypot(
            float(speeds.std()) / math.sqrt(cycles), FILM_ERROR * speed_m_s, 1e-5
        ),
        "gain_sigma": math.hypot(amplitude_sigma_rad / gait.alpha_rad, FILM_ERROR),
        "gains": ",".join(f"{abs(x) / gait.alpha_rad:.5f}" for x in phasors),
        "shifts_deg": ",".join(f"{shift:.3f}" for shift in shifts),
    }
