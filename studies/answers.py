"""Hold some 300 fixed cases to what they gave before, each within its claim: answers.json has them.

python studies/answers.py                 all cases, some two minutes; exit status 1 for a change
python studies/answers.py fit optimum     the cases of these kinds
python studies/answers.py --write         keep today's answers (a commit then says why)

A change is: a number beyond the sum of both claims, another word, a claim three times as wide. An
optimum that costs less is none. Where nothing claims an error, the allowed difference stands beside
the case, with its reason. Each case is drawn from its name alone: more cases change none.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr
from dataclasses import dataclass
from io import StringIO
from itertools import chain
from pathlib import Path
from random import Random
from typing import Any

import serpenoid as sn
from click.testing import CliRunner
from serpenoid.commands.main import cli
from serpenoid.model.gait import joint_motion

ANSWERS = Path(__file__).with_name("answers.json")
SESSIONS = Path(__file__).with_name("answer_sessions.tar.xz")  # taken in the virtual lab
PAPER = Path(__file__).resolve().parents[1] / "calibration_data" / "nirakh-2005"
Answer = dict[str, Any]  # quantity -> [value, claim], or a word
AT_REST_M_S = 1e-11  # speeds of gaits that go nowhere are rounding errors
ROUNDING = 1e-11  # of a value: another order of sums
WIDER = 3.0  # a claim so many times as wide is a change, unless it is within what was asked
# Intervals that draws or another minimiser find may move by 0.3 sigma: 0.15 from either answer.
FITTED = 0.15
SHIFT = 0.1  # of a band's width, from either answer: draws, and priors of servos


def between(r: Random, low: float, high: float) -> float:
    """Return a number between two, even in its logarithm."""
    return low * (high / low) ** r.random()


def a_robot(r: Random, links: tuple[int, ...] = (2, 3, 4, 6, 6, 6, 6, 10, 20)) -> sn.Robot:
    """Return a robot of 10 g to 2 kg a link."""
    return sn.Robot(r.choice(links), between(r, 0.01, 2.0), between(r, 0.04, 0.15))


def a_gait(r: Random) -> sn.Gait:
    """Return a gait; one in three turns."""
    offset = r.choice((0.0, 0.0, r.uniform(-0.3, 0.3)))
    return sn.Gait(r.uniform(0.3, 1.3), r.uniform(0.5, 1.7), between(r, 0.5, 12.0), offset)


def a_ground(r: Random, robot: sn.Robot, kind: str) -> sn.Ground:
    """Return viscous ground, dry ground of the wheels' weight, or dry ground on ratchet wheels."""
    weight_n = robot.link_mass_kg * 9.81
    ct = weight_n * between(r, 0.01, 0.3)
    cn = ct * between(r, 4.0, 100.0)
    if kind == "viscous":
        return sn.Ground(ct, cn)
    ft0 = weight_n * between(r, 0.01, 0.1)
    fn0 = ft0 * between(r, 1.5, 8.0)
    if kind == "ratchet":
        return sn.Ground((ct, 2 * ct), cn, (ft0, 5 * ft0), fn0)
    return sn.Ground(ct, cn, ft0, fn0)


def parts(r: Random, kind: str) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    """Return a robot, its ground and its gait."""
    robot = a_robot(r)
    return robot, a_ground(r, robot, kind), a_gait(r)


def steady(kind: str) -> Callable[[Random], Answer]:
    """Return the case of a periodic state on such ground."""

    def case(r: Random) -> Answer:
        state = sn.steady_gait(*parts(r, kind))
        return {
            "speed_m_s": [state.speed_m_s, state.error_estimate * abs(state.speed_m_s)],
            "power_w": [state.power_w, state.power_error_w],
            "abs_power_w": [state.abs_power_w, state.abs_power_error_w],
            "positive_power_w": [state.positive_power_w, state.positive_power_error_w],
            "turn_rad": [state.turn_rad_per_cycle, state.turn_error_rad],
            "settling_time_s": [
                state.settling_time_s,
                state.settling_error * state.settling_time_s,
            ],
        }

    return case


def springs(r: Random) -> Answer:
    """Return a periodic state on the implicit model's springs."""
    state = sn.steady_springs(*parts(r, "viscous"))
    return {
        "speed_m_s": [state.speed_m_s, state.error_estimate * abs(state.speed_m_s)],
        "power_w": [state.power_w, state.power_error_w],
        "positive_power_w": [state.positive_power_w, state.positive_power_error_w],
    }


def robot_of_2005(r: Random) -> tuple[sn.Robot, sn.Ground, sn.Gait]:
    """Return a robot that a servo can move, on ground like that of 2005."""
    friction = {"ct": 0.084, "cn": 1.2, "ft0": 0.14, "fn0": 0.27}
    frictions = {name: value * between(r, 0.7, 1.4) for name, value in friction.items()}
    gait = sn.Gait(r.uniform(0.7, 1.3), r.uniform(0.8, 1.5), r.uniform(2.0, 6.0))
    return sn.Robot(6, 0.0756, 0.076), sn.Ground.whole_body(6, **frictions), gait


def servo(r: Random) -> Answer:
    """Return the speed with one servo."""
    kind = sn.servo(r.choice(("SG90", "MG996R", "hobby")))
    state = sn.steady_gait(*robot_of_2005(r), servo=kind.servo)
    return {
        "speed_m_s": [state.speed_m_s, state.error_estimate * abs(state.speed_m_s)],
        "amplitude_ratio": [state.amplitude_ratio, state.error_estimate],
    }


def band(r: Random) -> Answer:
    """Return the band of any servo of a kind."""
    kind = sn.servo(r.choice(("SG90", "MG996R", "hobby")))
    state = sn.steady_gait(*robot_of_2005(r), servo=kind)
    return between_ends("speed_m_s", state.low_m_s, state.high_m_s, SHIFT)


def between_ends(name: str, low: float, high: float, share: float) -> Answer:
    """Return the two ends of a band, which may move by a share of its width."""
    return {
        f"{name} low": [low, share * (high - low)],
        f"{name} high": [high, share * (high - low)],
    }


def derivatives(r: Random) -> Answer:
    """Return the per cents of speed for 1 % of each of seven numbers."""
    kind = r.choice(("viscous", "dry"))
    state = sn.steady_gait(*parts(r, kind), sensitivities=True)
    rows = state.sensitivities.to_dict()
    return {f"speed by {name}": [row["percent"], row["error"]] for name, row in rows.items()}


def grid(r: Random) -> Answer:
    """Return the speeds of eight gaits."""
    robot, ground, gait = parts(r, r.choice(("viscous", "dry")))
    axes = {
        name: [getattr(gait, name), 1.1 * getattr(gait, name)]
        for name in ("alpha_rad", "beta_rad", "omega_rad_s")
    }
    swept = sn.sweep(robot, ground, **axes, threads=1)
    errors = abs(swept.error_estimate * swept.speed_m_s)
    speeds = {
        f"speed_m_s {k}": [float(v), float(e)]
        for k, (v, e) in enumerate(zip(swept.speed_m_s.flat, errors.flat, strict=True))
    }
    powers = zip(swept.power_w.flat, swept.power_error_w.flat, strict=True)
    return speeds | {f"power_w {k}": [float(v), float(e)] for k, (v, e) in enumerate(powers)}


def wanted_case(r: Random, kind: str) -> tuple[sn.Robot, sn.Ground, float]:
    """Return a robot, its ground and a speed that it can crawl at: that of some gait."""
    robot = a_robot(r, (3, 4, 6, 6, 6, 8))
    ground = a_ground(r, robot, kind)
    gait = sn.Gait(r.uniform(0.7, 1.1), r.uniform(0.8, 1.3), between(r, 1.0, 6.0))
    return robot, ground, 0.5 * abs(sn.steady_gait(robot, ground, gait).speed_m_s)


def optimum(kind: str) -> Callable[[Random], Answer]:
    """Return the case of the least power for a speed; "limits" sets bounds to the gait."""

    def case(r: Random) -> Answer:
        robot, ground, speed_m_s = wanted_case(r, "dry" if kind == "limits" else kind)
        bounds = sn.GaitLimits(joint_angle_rad=r.uniform(0.6, 1.0), servo_speed_rad_s=8.0)
        more: dict[str, Any] = {"limits": bounds} if kind == "limits" else {}
        cost = r.choice(("power", "positive_power"))
        best = sn.least_power_gait(robot, ground, speed_m_s=speed_m_s, cost=cost, **more)
        return {"speed_m_s": [best.speed_m_s, 1e-5 * speed_m_s]} | power_of(best)

    return case


def power_of(best: Any) -> Answer:
    """Return a least power, and that its gait does take it."""
    state = best.steady
    shown = state.positive_power_w if best.cost == "positive_power" else state.power_w
    same = abs(shown - best.power_w) <= 1e-6 * best.power_w
    return {"least power_w": [best.power_w, best.power_error_w], "its gait takes it": str(same)}


def front(r: Random) -> Answer:
    """Return least powers over three speeds."""
    robot, ground, speed_m_s = wanted_case(r, r.choice(("viscous", "dry")))
    speeds = [0.5 * speed_m_s, 0.75 * speed_m_s, speed_m_s]
    front = sn.power_front(robot, ground, speeds_m_s=speeds)
    return {f"least power_w {k}": [b.power_w, b.power_error_w] for k, b in enumerate(front)}


def losses(r: Random) -> Answer:
    """Return the shares of speed that a gait loses; its states are good to 1e-5."""
    losses = sn.speed_losses(*robot_of_2005(r)).to_dict()
    return {name: [value, 1e-4] for name, value in losses.items()}


def acceleration(r: Random) -> Answer:
    """Return one evaluation of either formulation."""
    robot, ground, gait = parts(r, r.choice(("viscous", "dry")))
    state = sn.LinkState.in_gait(robot, gait, r.random(), [0.0, 0.0, 0.3], [0.05, 0.01, 0.2])
    torque = {"torque_nm": [r.uniform(-0.05, 0.05) for _ in range(robot.links - 1)]}
    turn = joint_motion(gait, robot.links - 1, 0.2).acceleration_rad_s2
    joints = r.choice((torque, {"joint_acceleration_rad_s2": turn}))
    how = r.choice(("explicit", "implicit")) if joints is torque else "explicit"
    accelerations = sn.acceleration(robot, ground, state, **joints, formulation=how)
    size = max(abs(v) for v in accelerations.alpha_rad_s2)
    return {
        f"alpha_rad_s2 {k}": [float(v), 1e-10 * size]
        for k, v in enumerate(accelerations.alpha_rad_s2)
    }


RUNS: tuple[dict[str, Any], ...] = (
    {},
    {"method": "dop853"},
    {"method": "rk4"},
    {"method": "dop853", "tolerance": 1e-9},
    {"drive": "torque"},
    {"drive": "servo"},
    {"limp": (2,)},
    {"locked": {1: 0.3}},
    {"incline_rad": 0.05, "incline_direction_rad": 1.0},
    {"formulation": "implicit"},
    {"formulation": "implicit", "method": "rk4", "dt_s": 2e-4},
    {"formulation": "implicit", "method": "radau"},
)


def run(how: str) -> Callable[[Random], Answer]:
    """Return the case of a run of two periods: viscous, dry by its law"""

    def case(r: Random, number: int) -> Answer:
        robot, ground, gait = parts(r, "viscous" if how == "viscous" else "dry")
        robot = sn.Robot(r.choice((3, 4, 6)), robot.link_mass_kg, robot.link_length_m)
        fields = {"duration_s": 4 * math.pi / gait.omega_rad_s, **RUNS[number % len(RUNS)]}
        if fields.get("drive") == "torque":
            rows = [[r.uniform(-1, 1) * 0.02 for _ in range(robot.links - 1)] for _ in range(6)]
            times = [k * fields["duration_s"] / 5 for k in range(6)]
            fields["torque"] = sn.TorqueTable(times, rows)
        if fields.get("drive") == "servo":
            fields["servo"] = sn.servo("SG90").servo
        return ran(sn.Scene(robot, ground, gait, **fields))

    return case


def ran(scene: sn.Scene) -> Answer:
    """Return where a run ends, with its claims; where it does not settle, that alone."""
    done = sn.simulate(scene)
    error = done.error_estimate
    if not error.settled:
        return {"settled": "no"}
    place, angle = error.integration.position_m, error.integration.angle_rad
    return {
        "settled": "yes",
        "tail x_m": [float(done.x_m[-1, 0]), place],
        "tail y_m": [float(done.y_m[-1, 0]), place],
        "head theta_rad": [float(done.theta_rad[-1, -1]), angle],
    }


SIX, USUAL, PAPER_GROUND = sn.Robot(6, 1.0, 0.12), sn.Gait(0.52, 1.4, 5.0), sn.Ground(0.1, 10.0)
ON_SPRINGS = {"formulation": "implicit", "duration_s": 1.0}
EXTREMES: tuple[tuple[sn.Robot, sn.Ground, sn.Gait, dict[str, Any]], ...] = (
    (SIX, PAPER_GROUND, sn.Gait(2.97, 1.4, 5.0), {}),
    (SIX, PAPER_GROUND, sn.Gait(0.52, 1.4, 0.01), {"duration_s": 200.0}),
    (SIX, PAPER_GROUND, sn.Gait(0.52, 1.4, 100.0), {"duration_s": 0.5}),
    (SIX, sn.Ground(10.0, 1e-5), USUAL, {}),
    (SIX, sn.Ground(1e-5, 10.0), USUAL, {}),
    (SIX, sn.Ground(1.0, 1e5), USUAL, {}),
    (SIX, sn.Ground(0.0, 0.0), USUAL, {}),
    (sn.Robot(6, 1e-6, 0.12), PAPER_GROUND, USUAL, {"duration_s": 1.0}),
    (sn.Robot(6, 1e3, 0.12), PAPER_GROUND, USUAL, {}),
    (sn.Robot(50, 1.0, 0.12), PAPER_GROUND, sn.Gait(0.17, 0.13, 5.0), {"duration_s": 1.0}),
    (sn.Robot(200, 1.0, 0.12), PAPER_GROUND, sn.Gait(0.17, 0.06, 5.0), {"duration_s": 0.2}),
    (SIX, sn.Ground(0.1, 10.0, 5.0, 5.0), sn.Gait(0.52, 1.4, 1.0), {}),
    (SIX, sn.Ground(0.1, 1e6, 0.5, 5.0), USUAL, {"duration_s": 1.0}),
    (SIX, sn.Ground(0.1, 10.0, 0.0, 0.0), USUAL, {"duration_s": 300.0, "record_every": 1000}),
    (SIX, PAPER_GROUND, USUAL, {**ON_SPRINGS, "joint_stiffness_n_m": 1e5, "method": "radau"}),
    (SIX, PAPER_GROUND, USUAL, {**ON_SPRINGS, "joint_stiffness_n_m": 1e7, "method": "radau"}),
    (SIX, PAPER_GROUND, USUAL, {**ON_SPRINGS, "joint_stiffness_n_m": 1e9, "method": "radau"}),
    (SIX, PAPER_GROUND, USUAL, {**ON_SPRINGS, "joint_stiffness_n_m": 9e5, "method": "rk4"}),
    (SIX, PAPER_GROUND, USUAL, {**ON_SPRINGS, "joint_stiffness_n_m": 1e8, "method": "rk4"}),
    (SIX, sn.Ground(0.1, 10.0, 0.5, 5.0), USUAL, {**ON_SPRINGS, "joint_stiffness_n_m": 1e6}),
)


def extreme(_r: Random, number: int) -> Answer:
    """Return where an extreme run ends."""
    robot, ground, gait, more = EXTREMES[number]
    return ran(sn.Scene(robot, ground, gait, **({"duration_s": 2.0} | more)))


# The session of 2005, then those taken by the procedure in the virtual lab, of robots with 4 to 12
# links; tape and watch alone, and too few readings in a bend, are refused.
FOLDERS = (
    "paper", "belt-one-bend", "belt-three-bends", "belt-steep", "belt-with-crawls",
    "floor-0", "floor-3", "floor-5", "floor-with-crawls",
    *(f"belt-{number:02d}" for number in range(14)),
    *(f"floor-{number:02d}" for number in range(17)),
)  # fmt: skip
CRAWLS = ("belt-with-crawls", "floor-with-crawls")


def folder_of(name: str) -> Path:
    """Return a session's folder; that of a stored session is written below the current folder."""
    if name == "paper":
        return PAPER
    with tarfile.open(SESSIONS) as archive:
        members = [m for m in archive.getmembers() if m.name.startswith(f"sessions/{name}/")]
        archive.extractall(members=members, filter="data")
    return Path("sessions", name)


def fit(method: str) -> Callable[[Random, int], Answer]:
    """Return the case of frictions with their intervals."""

    def case(_r: Random, number: int) -> Answer:
        return fitted(sn.fit_friction(sn.load_session(folder_of(FOLDERS[number])), method=method))

    return case


def fitted(fit: sn.FrictionFit) -> Answer:
    """Return frictions and their intervals, which may move by a share of sigma."""
    answer: Answer = {"dof": str(fit.dof), "alarms": str(len(fit.alarms))}
    for name, estimate in fit.parameters.items():
        ends = zip(("value", "low", "high"), (estimate.value, *fit.intervals[name]), strict=True)
        answer |= {f"{name} {end}": [value, FITTED * estimate.sigma] for end, value in ends}
    return answer


def predict(_r: Random, number: int) -> Answer:
    """Return the bands and the verdict of a session's crawls."""
    session = sn.load_session(folder_of(CRAWLS[number % 2]))
    more = {"servo": None} if number // len(CRAWLS) else {}
    compared = sn.compare(session, samples=64, **more)
    answer: Answer = {"verdict": compared.verdict}
    for k, g in enumerate(compared.gaits):
        answer |= between_ends(f"friction m_s {k}", g.low_friction_m_s, g.high_friction_m_s, SHIFT)
        if g.too_fast:  # beyond what servos can run
            answer[f"all m_s {k}"] = "no band"
        else:
            answer |= between_ends(f"all m_s {k}", g.low_m_s, g.high_m_s, SHIFT)
    return answer


def command_answer(*words: object) -> dict[str, Any]:
    """Return what a command answers."""
    done = CliRunner().invoke(cli, [*map(str, words), "--json"], catch_exceptions=False)
    return json.loads(done.stdout)


def advice(_r: Random, number: int) -> Answer:
    """Return the band today and after the best reading, which draws tell to a tenth."""
    folder = folder_of(("paper", "belt-one-bend", "floor-0")[number])
    answer = command_answer("advise", folder, "--gait", 70, 75, 0.5, "--servo", "ideal")
    bands = {"band": answer["band"], "best": answer["readings"][0]["band"]}
    return {name: [value, 0.05 * value] for name, value in bands.items()}


def film(_r: Random) -> Answer:
    """Return what the demo's film tells."""
    answer = command_answer("video", PAPER.with_name("demo-film") / "film.mp4")
    names = ("speed", "turn", "omega")
    units = {"speed": "m_s", "turn": "rad_s", "omega": "rad_s"}
    figures = {
        n: [answer[f"{n}_{units[n]}"], FITTED * answer[f"{n}_sigma_{units[n]}"]] for n in names
    }
    return figures | {
        f"joint {j['joint']}": [j["amplitude_rad"], FITTED * j["amplitude_sigma_rad"]]
        for j in answer["joints"]
    }


def bench_test(r: Random) -> Answer:
    """Return a servo measured by its steps: its speed without load, where the test tells it."""
    no_load, lag_s, angle, rows = r.uniform(4.0, 10.0), r.uniform(0.02, 0.06), 0.0, []
    for k in range(200):
        goal = 40.0 * (k // 50 % 2)
        step = (goal - angle) * (1 - math.exp(-0.02 / lag_s))
        angle += math.copysign(min(abs(step), math.degrees(no_load) * 0.02), step)
        rows.append(f"{k / 50},{goal},{angle + r.gauss(0, 0.5)}\n")
    Path("bench.csv").write_text("t_s,setpoint_deg,angle_deg\n" + "".join(rows))
    determined = command_answer("servo", "--test", "bench.csv")["determined"]
    measured = determined.get("no_load_rad_s")
    return (
        {"no_load_rad_s": [measured["value"], FITTED * measured["sigma"] * measured["value"]]}
        if measured
        else {}
    )


REFUSED = (
    "steady --alpha-deg 200 --beta-deg 75 --omega-rad-s 5",
    "steady --alpha-deg 70 --beta-deg 75",
    "steady --alpha-deg 70 --beta-deg 75 --omega-rad-s 5 --set ct=-1",
    "steady --alpha-deg 70 --beta-deg 75 --omega-rad-s 5 --set rtol=1e-20",
    "simulate --robot paper --formulation implicit --set dt_s=1 --method rk4 --duration-s 2",
    "simulate --robot paper --set links=1",
    "optimize --robot paper --speed-m-s 50",
    "fit nowhere",
    "compare nowhere",
    "sweep --alpha-deg 60:50:1",
)


def refusal(_r: Random, number: int) -> Answer:
    """Return how a command line that asks for too much ends."""
    done = CliRunner().invoke(cli, REFUSED[number].split())
    return {"exit": str(done.exit_code), "error": type(done.exception).__name__}


@dataclass(frozen=True)
class Kind:
    """A kind of case: how many, and how it is computed; accuracy: that was asked, relative."""

    count: int
    case: Callable[..., Answer]
    accuracy: float = 0.0
    numbered: bool = False  # the case takes its number, too


KINDS = {
    "steady-viscous": Kind(44, steady("viscous"), 1e-6),
    "steady-dry": Kind(46, steady("dry"), 1e-6),
    "steady-ratchet": Kind(10, steady("ratchet"), 1e-6),
    "springs": Kind(10, springs, 1e-4),
    "servo": Kind(14, servo, 1e-3),
    "band": Kind(8, band),
    "derivatives": Kind(8, derivatives, 1e-5),
    "grid": Kind(10, grid, 1e-6),
    "optimum-viscous": Kind(12, optimum("viscous"), 1e-3),
    "optimum-dry": Kind(8, optimum("dry"), 3e-3),
    "optimum-limits": Kind(6, optimum("limits"), 3e-3),
    "front": Kind(2, front, 3e-3),
    "losses": Kind(6, losses),
    "acceleration": Kind(10, acceleration),
    "run-viscous": Kind(12, run("viscous"), 1e-6, True),
    "run-dry": Kind(12, run("dry"), 1e-6, True),
    "extreme": Kind(20, extreme, 1e-6, True),
    "fit": Kind(40, fit("joint"), 0.0, True),
    "predict": Kind(4, predict, 0.0, True),
    "advice": Kind(3, advice, 0.0, True),
    "film": Kind(1, film),
    "bench-test": Kind(3, bench_test),
    "refusal": Kind(10, refusal, 0.0, True),
}


def names(kinds: list[str]) -> list[str]:
    """Return the cases of these kinds, or of all: `fit 3` is the fourth fit."""
    cases = ([f"{kind} {k}" for k in range(KINDS[kind].count)] for kind in kinds or KINDS)
    return list(chain.from_iterable(cases))


def answer_of(name: str) -> Answer:
    """Compute a case; an error of this package is an answer, too. The current folder is written."""
    kind, number = name.rsplit(" ", 1)
    case = KINDS[kind]
    try:
        answer = case.case(Random(name), *([int(number)] * case.numbered))
    except sn.SerpenoidError as error:
        return {"refused": type(error).__name__}
    return {quantity: plain(value) for quantity, value in answer.items()}


def plain(value: Any) -> Any:
    """Return a value and its claim as JSON has them; in words where either is not finite."""
    if isinstance(value, str) or value[0] is None:
        return str(value)
    # A value whose error is not known counts by six digits, as sums in another order keep them.
    return [float(v) for v in value] if all(map(math.isfinite, value)) else f"{value[0]:.6g}"


def changes(name: str, old_answer: Answer, new_answer: Answer) -> Iterator[tuple[str, ...]]:
    """Yield what changed beyond the claims: case, quantity, before, now, what is wrong."""
    accuracy = KINDS[name.rsplit(" ", 1)[0]].accuracy
    for quantity in {**old_answer, **new_answer}:
        old, new = old_answer.get(quantity, "absent"), new_answer.get(quantity, "absent")
        if isinstance(old, str) or isinstance(new, str):
            if old != new:
                yield name, quantity, str(old), str(new), "another answer"
            continue
        tolerance = AT_REST_M_S if quantity.startswith("speed_m_s") else 0.0
        difference, allowed = new[0] - old[0], old[1] + new[1] + ROUNDING * abs(old[0]) + tolerance
        row = name, quantity, f"{old[0]:.9g} ± {old[1]:.1e}", f"{new[0]:.9g} ± {new[1]:.1e}"
        if (difference if quantity.startswith("least ") else abs(difference)) > allowed:
            yield *row, f"off by {abs(difference) / allowed:.3g} times what is allowed"
        elif new[1] > WIDER * old[1] + accuracy * size(quantity, new[0]):
            yield *row, f"a claim {new[1] / max(old[1], 1e-300):.3g} times as wide"


def size(quantity: str, value: float) -> float:
    """Return what an accuracy is relative to: of angles and places a radian or a metre, too."""
    return abs(value) + quantity.endswith(("_rad", "_m"))


def main() -> int:
    """Compute the cases anew, and print every change as a row of a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", choices=[*KINDS, []])
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    stored: dict[str, Answer] = json.loads(ANSWERS.read_text()) if ANSWERS.exists() else {}
    answers, rows, spent = {}, [], {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in names(arguments.kinds):
            begin = time.process_time()
            with redirect_stderr(StringIO()):
                answers[name] = answer_of(name)
            kind = name.rsplit(" ", 1)[0]
            spent[kind] = spent.get(kind, 0.0) + time.process_time() - begin
            rows += list(changes(name, stored.get(name, {}), answers[name]))
    if arguments.write:
        text = ",\n".join(
            f"{json.dumps(n)}: {json.dumps(a)}" for n, a in (stored | answers).items()
        )
        ANSWERS.write_text(f"{{\n{text}\n}}\n")
    for row in rows:
        print(" | ".join(row))
    times = ", ".join(f"{kind} {seconds:.1f}" for kind, seconds in spent.items())
    print(f"{len(answers)} cases, {len(rows)} changes beyond claims; processor time (s): {times}")
    return int(bool(rows) and not arguments.write)


if __name__ == "__main__":
    sys.exit(main())
