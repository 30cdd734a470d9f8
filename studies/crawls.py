"""Count how often intervals hold the truth where crawls are fitted, alone and beside pushes.

python studies/crawls.py alone 200     some 50 minutes of a core
python studies/crawls.py beside 200    some 10 minutes

Truths are drawn 20 % about the 2005 robot's frictions; the lab's robot has joints that stand 0.5
degrees off and an amplitude 3 % off. Tape and watch tell a crawl over a metre, or 40 s.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
from coverage_floor import CASES, UNSEEN, floor_setup
from serpenoid.calibration.friction_fit import fit_friction
from serpenoid.calibration.friction_result import NAMES
from serpenoid.calibration.speed_samples import AMPLITUDE_SIGMA, sample_speeds, scaled, speed
from serpenoid.calibration.taking.simulated import SimulatedPerson
from serpenoid.calibration.taking.treadmill import take_all
from serpenoid.calibration.taking.world import drawn_floor
from serpenoid.lab.crawl import crawl_speed
from serpenoid.model.errors import SerpenoidError
from serpenoid.model.gait import Gait
from serpenoid.model.ground import Ground
from serpenoid.periodic.servo_steady import band
from simulated_sessions import MemoryRecord

CENTRE, SPREAD = {"ct": 0.084, "cn": 1.2, "ft0": 0.14, "fn0": 0.27}, 0.2


def gaits(*rows: tuple[float, float, float]) -> tuple[Gait, ...]:
    """Return gaits of alpha and beta in degrees and a frequency in Hz."""
    return tuple(Gait(math.radians(a), math.radians(b), 2 * math.pi * f) for a, b, f in rows)


BESIDE = gaits((70, 60, 0.8), (80, 75, 0.4))
ALONE = gaits(
    (80, 75, 0.4),
    (70, 75, 0.5),
    (80, 60, 0.25),
    (70, 60, 0.8),
    (50, 45, 0.7),
    (85, 75, 0.6),
    (60, 60, 0.3),
    (75, 90, 0.35),
)


def one(alone: bool, number: int) -> list[float] | None:
    """Take and fit a session; return what held and what an unseen gait's speed is off by."""
    rng = np.random.default_rng([20, number, alone])
    setup = floor_setup(CASES[0])
    plan = replace(
        setup.procedure,
        gaits=ALONE if alone else BESIDE,
        gait_runs=1,
        pushes=0 if alone else setup.procedure.pushes,
    )
    setup = replace(setup, procedure=plan)
    friction = {k: v * math.exp(SPREAD * rng.normal()) for k, v in CENTRE.items()}
    amplitude = 1.0 + AMPLITUDE_SIGMA * float(rng.normal())
    truth = replace(drawn_floor(setup, Ground(**friction), rng), amplitude=amplitude)
    person = SimulatedPerson(setup, truth, int(rng.integers(2**31)))
    taken = take_all(MemoryRecord(setup), person)
    fits = []
    for crawls in (True,) if alone else (True, False):
        try:
            fits.append(fit_friction(taken, crawls=crawls))
        except SerpenoidError as error:
            print(error, file=sys.stderr)
            return None
    fit, true = fits[0], np.array(list(friction.values()))
    ends = np.array([fit.intervals[name] for name in NAMES])
    held = (ends[:, 0] <= true) & (true <= ends[:, 1])
    gait = UNSEEN[number % len(UNSEEN)]
    moved = crawl_speed(person.robot, scaled(gait, amplitude))
    low, high = band(sample_speeds(fit, [gait], amplitude_sigma=AMPLITUDE_SIGMA).both_m_s[:, 0])
    told = [speed(fit.robot, fit.ground, scaled(gait, fit.nuisances["joint_amplitude"].value))]
    told += [speed(f.robot, f.ground, scaled(gait, a)) for f in fits[1:] for a in (1.0, amplitude)]
    off = [abs(v / moved - 1.0) for v in told]
    return [*held, low <= moved <= high, *(ends[:, 1] / ends[:, 0]), (high - low) / moved / 2, *off]


def main() -> None:
    """Print shares, widths and errors as sessions come in."""
    alone, sessions = sys.argv[1] == "alone", int(sys.argv[2])
    found = []
    for number in range(sessions):
        found.append(one(alone, number))
        told = np.array([row for row in found if row is not None])
        if len(told) and not (number + 1) % 10:
            rows = {
                "held: ct, cn, ft0, fn0, unseen": told[:, :5].mean(axis=0),
                "upper over lower ends": np.median(told[:, 5:9], axis=0),
                "band": np.median(told[:, 9]),
                "unseen off: with crawls; pushes, commanded, amplitude known": np.median(
                    told[:, 10:], axis=0
                ),
                "in a tenth": np.quantile(told[:, 10:], 0.9, axis=0),
            }
            print(number + 1, "refused", len(found) - len(told), flush=True)
            for name, values in rows.items():
                print(f"  {name}:", np.round(values, 3), flush=True)


if __name__ == "__main__":
    main()
