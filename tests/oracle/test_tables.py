"""States of the tables of periodic gaits come back after a period by contact_modes.py.

Integrations of other make wrote the tables. In random and springs, u0 is of the centre of mass.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from simulation import truth_cases as tc

from . import contact_modes, explicit, implicit, joint_work
from .params import Array, Gait, Params


def row_of(table: str, index: int) -> tuple[dict[str, float], Params, Gait]:
    """Return a row of a table, its robot on its ground, and its gait."""
    with Path(__file__).with_name(f"periodic_{table}.csv").open(newline="") as file:
        row = {key: float(text) for key, text in list(csv.DictReader(file))[index].items()}
    half = row["half_m"] if table == "springs" else row["half_length_m"]
    names = ("ft0", "fn0", "ct_back", "ft0_back")
    dry = {name: row[name] for name in names if name in row}
    inertia = row.get("inertia_kg_m2")
    p = Params(int(row["links"]), row["mass_kg"], half, inertia, row["ct"], row["cn"], **dry)
    offset = row.get("offset_rad", 0.0)
    return row, p, Gait(row["alpha_rad"], row["beta_rad"], row["omega_rad_s"], offset)


def still(p: Params) -> contact_modes.Drive:
    return contact_modes.Drive(np.zeros(1), np.zeros((1, p.links - 1)))


def a_period(world: contact_modes.World, start: Array, gait: Gait) -> tuple[float, float, float]:
    """Return the mean speed, the turn, and how far the state misses itself as seen from link 1."""
    (end,) = contact_modes.run(
        world, start, np.array([gait.period_s]), rtol=1e-9, longest_s=gait.period_s / 100
    )
    (first, first_rates), (last, last_rates) = (y.reshape(2, -1, 3) for y in (start, end))
    turn = last[0, 2] - first[0, 2]
    back = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    miss = np.column_stack([last_rates[:, :2] @ back, last_rates[:, 2]]) - first_rates
    miss[:, 2] *= 2 * world.p.half_length_m
    size = gait.omega_rad_s * gait.alpha_rad * world.p.half_length_m
    way = (last - first)[:, :2].mean(0) if abs(turn) < 1e-9 else np.full(2, np.nan)
    return float(np.hypot(*way)) / gait.period_s, float(turn), float(abs(miss).max()) / size


@pytest.mark.parametrize(
    ("table", "index"),
    [
        ("random", 2),
        ("viscous", 10),
        *(pytest.param("random", k, marks=pytest.mark.slow) for k in (0, 7, 9, 18)),
        *(pytest.param("viscous", k, marks=pytest.mark.slow) for k in (1, 29, 54)),
    ],
)
def test_pinned_links(table: str, index: int) -> None:
    row, p, gait = row_of(table, index)
    u0 = np.array([row["u0_x_m_s"], row["u0_y_m_s"], row["u0_spin_rad_s"]])
    phi, phi_rate, _ = gait.angles(0.0, p.links - 1)
    shape, moving = explicit.whole_state(np.zeros(3), phi), explicit.whole_state(u0, phi_rate)
    places, rates = implicit.closed_links(p, shape, moving)
    if table == "random":
        rates[:, :2] += u0[:2] - rates[:, :2].mean(0)
    start = np.concatenate([places.ravel(), rates.ravel()])
    world = joint_work.GaitWorld(p, still(p), gait)
    speed_m_s, turn_rad, miss = a_period(world, start, gait)
    assert miss < 1e-7  # the tolerance of the run, over the slowest wheel's share of it
    assert turn_rad == pytest.approx(row["turn_rad_per_cycle"], rel=3e-5, abs=1e-9)
    if np.isfinite(speed_m_s):
        assert speed_m_s == pytest.approx(row["speed_m_s"], rel=1e-8)
    work = joint_work.positive_work(world, start, gait.period_s, 1e-9, gait.period_s / 100)
    positive_w = row["positive_power_w"] * (1 + 3 * row.get("work_missed", 0.0))
    assert work / gait.period_s == pytest.approx(positive_w, rel=1e-6)


@pytest.mark.parametrize("index", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_springs(index: int) -> None:
    """The state is where a run of the package comes to rest; its speed is that of the table."""
    row, p, gait = row_of("springs", index)
    scene = sn.Scene(
        sn.Robot(p.links, p.mass_kg, 2 * p.half_length_m),
        sn.Ground(p.ct, p.cn),
        sn.Gait(gait.alpha_rad, gait.beta_rad, gait.omega_rad_s),
        formulation="implicit",
        joint_stiffness_n_m=row["stiffness_n_m"],
        joint_damping_n_s_m=row["damping_n_s_m"],
        start="steady",
        method="radau",
        tolerance=1e-9,
        duration_s=12 * gait.period_s,
        dt_s=gait.period_s,
    )
    start = tc.packed(sn.simulate(scene).state())
    speed_m_s, _, miss = a_period(tc.world(scene), start, gait)
    assert miss < 1e-6
    assert speed_m_s == pytest.approx(row["speed_m_s"], rel=1e-6)
