"""Sessions with known truth from plain NumPy: no procedure, treadmill or fit of the package."""

from dataclasses import dataclass

import numpy as np
from serpenoid import Session
from serpenoid.session.checks import BendCheck, ZeroReading
from serpenoid.session.instruments import Instruments
from serpenoid.session.settings import Laboratory, Plan, Provenance, RobotTable, Setup
from serpenoid.session.station import Reading

G, STEPS_DEG, BEND_SIGMA_DEG = 9.81, 0.1, 0.5  # of gravity, inclinometer and protractor


@dataclass(frozen=True)
class World:
    """What is true: a robot's mass and friction, instruments, a treadmill, what goes wrong.

    grade: the treadmill's step, 0 for any incline. zero_drift_deg: over 24 stations, evenly.
    misread_deg: one incline typed wrong by this.
    """

    mass_kg: float = 0.4536
    ct: float = 0.084
    cn: float = 1.2
    ft0: float = 0.14
    fn0: float = 0.27
    grade: float = 0.005
    speed_sigma: float = 0.012
    zero_drift_deg: float = 0.0
    misread_deg: float = 0.0
    bends_deg: tuple[float, ...] = (7.5, 15.0, 30.0)
    top_m_s: float = 1.0

    @property
    def truth(self):
        """Return ct, cn, ft0, fn0 of the whole snake."""
        return np.array([self.ct, self.cn, self.ft0, self.fn0])

    def slip(self, incline, bend):
        """Return the slip at which the snake stays where it is."""
        c, s = np.cos(bend), np.sin(bend)
        pull = self.mass_kg * G * np.sin(incline) - self.ft0 * c - self.fn0 * s
        return pull / (self.ct * c**2 + self.cn * s**2)


def shown(incline):
    """Round as an inclinometer does."""
    return np.radians(np.round(np.degrees(incline) / STEPS_DEG) * STEPS_DEG)


def inclines(world, bend, deck, rng):
    """Return the inclines that the treadmill is set to, at most 8, up to the top speed."""
    if world.grade:
        grade = np.arange(0.0, 0.2, world.grade * max(1, round(0.0052 / world.grade)))
        found = np.arctan(grade) + deck
    else:
        found = np.radians(np.arange(0.3, 11.0, 0.29) + rng.uniform(-0.1, 0.1, 37)) + deck
    slip = world.slip(found, bend)
    held = found[(slip > 0.04) & (slip < world.top_m_s)]
    return held[:: max(1, len(held) // 8)]


def plain_session(world, rng):
    """Take a session: zero, straight, every bend with its check, zero."""
    zero, deck = np.radians([rng.normal() * 0.15, rng.uniform(-0.15, 0.15)])
    rows, checks, zeros = [], [], []

    def read_zero(number, now):
        slope = np.radians(rng.uniform(-0.4, 0.4))
        ends = [float(shown(sign * slope + now)) for sign in (1, -1)]
        zeros.append(ZeroReading(number, *ends, before=not rows))

    read_zero(1, zero)
    number, count = 1, 0
    drift = np.radians(world.zero_drift_deg)
    for bend_deg in (0.0, *world.bends_deg):
        bend = np.radians(bend_deg)
        true_bend = bend + (np.radians(rng.normal()) if bend_deg else 0.0)
        told = 0.0
        if bend_deg:
            number += 1
            seen = np.degrees(true_bend) + rng.normal() * BEND_SIGMA_DEG
            between = round(180 - 2 * seen, 1)
            checks.append(BendCheck(number, float(bend), float(np.radians(between))))
            told = checks[-1].found_rad
        for incline in inclines(world, true_bend, deck, rng):
            number, count = number + 1, count + 1
            slip = world.slip(incline, true_bend) + rng.normal() * world.speed_sigma
            belt = np.round(slip / 0.02778) * 0.02778
            now = zero + drift * count / 24
            seen = shown(incline + now)
            if slip > 0.0:
                rows.append([number, told, float(seen), float(belt), float(belt - slip)])
    read_zero(number + 1, zero + drift * (count + 1) / 24)
    misread = rng.permutation(len(rows))[0]
    rows[misread][2] += float(np.radians(world.misread_deg))
    return _session(world, rows, checks, zeros)


def _session(world, rows, checks, zeros):
    # regenerated: its belt runs as its instruments state
    setup = Setup(
        "plain",
        Provenance(kind="regenerated", source="a test", note="none"),
        RobotTable(links=6, mass_kg=world.mass_kg, link_length_m=0.076),
        Laboratory(surface="belt", place="a test", people="nobody", gravity_m_s2=G),
        Instruments(
            incline_sigma_deg=STEPS_DEG / np.sqrt(12),
            incline_zero_sigma_deg=0.1,
            belt_speed_sigma_m_s=world.speed_sigma,
            lambda_sigma_deg=BEND_SIGMA_DEG,
            incline_step_percent=100 * world.grade or 0.01,
        ),
        Plan(
            lambda_deg=(0.0, *world.bends_deg),
            incline_start_deg=1.7,
            incline_step_deg=0.3,
            belt_speed_max_m_s=world.top_m_s,
        ),
    )
    return Session(
        setup, tuple(Reading(*row) for row in rows), zeros=tuple(zeros), bends=tuple(checks)
    )
