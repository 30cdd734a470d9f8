"""Periodic states: published figures, independent references, symmetry, limits, honest errors."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
import serpenoid as sn
from robots import BINGHAM, OF_2005, PAPER, VISCOUS, gait_in_deg

REFERENCE = Path(__file__).parents[2] / "oracle"


def test_the_papers_gait() -> None:
    s = sn.steady_gait(PAPER, VISCOUS, gait_in_deg(30, 80, 5), rtol=1e-9)
    assert s.speed_m_s == pytest.approx(0.292060796024, rel=2e-12)
    assert s.power_w == pytest.approx(0.073312554830, rel=2e-11)
    # seven digits are published
    assert s.abs_power_w == pytest.approx(0.5146735, rel=1e-7)
    assert s.positive_power_w == pytest.approx(0.2939930, rel=1e-7)


def test_the_robot_of_2005() -> None:
    s = sn.steady_gait(OF_2005, BINGHAM, gait_in_deg(70, 75, 5))
    assert s.speed_m_s == pytest.approx(0.133205, rel=4e-6)
    slow = sn.steady_gait(OF_2005, BINGHAM, gait_in_deg(70, 75, 1))
    assert slow.speed_m_s == pytest.approx(0.03317, rel=2e-4)


@pytest.mark.parametrize("ground", [VISCOUS, BINGHAM], ids=["viscous", "dry"])
def test_a_run_in_time_settles_to_it(ground: sn.Ground) -> None:
    """From another start the motion converges to it, as fast as the multipliers say."""
    gait = gait_in_deg(60, 75, 6)
    s = sn.steady_gait(OF_2005, ground, gait, rtol=1e-7)
    cycles = math.ceil(12 * s.settling_time_s / gait.period_s) + 2
    run = sn.simulate(
        sn.Scene(
            OF_2005,
            ground,
            gait,
            method="nonsmooth" if ground.dry else "rk4",
            dt_s=gait.period_s / 400,
            duration_s=cycles * gait.period_s,
            record_every=400,
            start="zero_momentum",
        )
    )
    x, y = run.x_m.mean(axis=1), run.y_m.mean(axis=1)
    speeds = np.hypot(np.diff(x), np.diff(y)) / gait.period_s
    # exp(-12) = 6e-6 of the start is left, and RK4 at 400 steps a period errs by 1e-8
    assert speeds[-1] == pytest.approx(s.speed_m_s, rel=2e-5)
    assert abs(speeds[0] / s.speed_m_s - 1) > 1e-2


def test_an_answer_that_is_not_good_enough_is_not_thrown_away() -> None:
    """Two heavy links that turn by inertia alone, 21 times a second."""
    robot = sn.Robot(2, 3.1361528892209254, 0.05966134695809396)
    ground = sn.Ground(
        0.00176635146747408, 0.021613012425747716, 0.0007097982789483057, 0.3163208176862016
    )
    gait = sn.Gait(0.9068710855146956, 2.1447184998632522, 131.50598113969176, 0.2)
    with pytest.raises(sn.NotConverged) as error:
        sn.steady_gait(robot, ground, gait, rtol=1e-7, powers=False)
    best = error.value.best
    assert isinstance(best, sn.Steady)
    assert best.error_estimate > 1e-7
    # what most tolerances come near to; the estimate is of what counts as a speed, if larger
    standard = max(best.speed_m_s, 1e-4 * 2 * robot.link_length_m * gait.omega_rad_s)
    assert abs(best.speed_m_s - 1.599221e-4) < best.error_estimate * standard


def test_the_path_of_a_turning_gait_hangs_on_no_phase() -> None:
    """Mirror images start half a cycle apart: same circle, other chords."""
    robot, ground = OF_2005, sn.Ground(0.014, 0.2)
    left, right = (
        sn.steady_gait(robot, ground, sn.Gait(0.6, 1.2, 4.0, o), rtol=1e-9) for o in (0.2, -0.2)
    )
    assert left.speed_m_s == pytest.approx(right.speed_m_s, rel=1e-9)
    assert left.radius_m == pytest.approx(right.radius_m, rel=1e-9)
    assert abs(left.chord_m_s / right.chord_m_s - 1) > 1e-3
    straight = sn.steady_gait(robot, ground, sn.Gait(0.6, 1.2, 4.0))
    assert straight.radius_m == math.inf
    assert straight.chord_m_s == straight.speed_m_s
    period = left.gait.period_s
    run = sn.simulate(
        sn.Scene(
            robot,
            ground,
            left.gait,
            start="steady",
            method="dop853",
            dt_s=period / 64,
            duration_s=40 * period,
        )
    )
    # the mean place over whole cycles goes round the circle: measured from 64 x 40 places
    place = (run.x_m.mean(axis=1) + 1j * run.y_m.mean(axis=1))[:-1].reshape(40, 64)
    turned = np.exp(1j * left.turn_rad_per_cycle * np.arange(40))
    step = np.diff(place, axis=0) / turned[:-1, None]  # the same for all cycles, phase by phase
    back = np.exp(-1j * left.turn_rad_per_cycle * np.arange(64) / 64)
    centre_to_place = (step / (turned[1] - 1)).mean(axis=0)
    assert abs((centre_to_place * back).mean()) == pytest.approx(left.radius_m, rel=1e-6)


def rows(name: str) -> list[dict[str, str]]:
    """Return a reference table; one that is missing or empty stops the whole collection."""
    with (REFERENCE / name).open(newline="") as file:
        found = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert found, f"{name} holds no row"
    return found


def test_no_motion_costs_no_power() -> None:
    still = sn.steady_gait(PAPER, VISCOUS, sn.Gait(0.0, 1.0, 3.0))
    assert still.speed_m_s < 1e-12
    assert still.power_w < 1e-12
    for ground in (VISCOUS, BINGHAM):  # all joints in phase: symmetry forbids travel
        s = sn.steady_gait(OF_2005, ground, sn.Gait(0.5, 0.0, 3.0))
        assert s.power_w > 0


@pytest.mark.parametrize("row", rows("periodic_viscous.csv"), ids=lambda r: r["links"])
def test_viscous_reference_table(row: dict[str, str]) -> None:
    """Shooting on the full period in velocities, and adaptive quadrature of |P|: other code."""
    v = {name: float(text) for name, text in row.items()}
    robot = sn.Robot(int(v["links"]), v["mass_kg"], 2 * v["half_length_m"], v["inertia_kg_m2"])
    gait = sn.Gait(v["alpha_rad"], v["beta_rad"], v["omega_rad_s"], v["offset_rad"])
    s = sn.steady_gait(robot, sn.Ground(v["ct"], v["cn"]), gait, rtol=1e-9)
    size = gait.omega_rad_s * robot.link_length_m * robot.links
    # the table's own accuracy is some 1e-12 of the scale of the motion
    assert s.chord_m_s == pytest.approx(v["speed_m_s"], rel=1e-9, abs=1e-12 * size)
    assert s.turn_rad_per_cycle == pytest.approx(v["turn_rad_per_cycle"], rel=1e-9, abs=1e-10)
    assert s.power_w == pytest.approx(v["power_w"], rel=1e-9)
    assert s.abs_power_w == pytest.approx(v["abs_power_w"], rel=1e-7)
    assert s.positive_power_w == pytest.approx(v["positive_power_w"], rel=1e-7)
    assert s.positive_power_error_w <= 1e-6 * s.positive_power_w
    slowest = abs(complex(v["multiplier1_re"], v["multiplier1_im"]))
    assert abs(s.floquet_multipliers[0]) == pytest.approx(slowest, rel=1e-6, abs=1e-9)


def test_errors_of_a_motion_with_a_long_memory_are_what_they_claim() -> None:
    """Friction takes 20 000 cycles to forget: one cycle's error is repeated as often."""
    robot = sn.Robot(34, 8.603133192418403, 0.01841195261926163)
    ground = sn.Ground(0.00011684949643648431, 0.0007194612325834184)
    gait = sn.Gait(1.1663787066988576, 0.26832900909664276, 5.495101313332529)
    truth = sn.steady_gait(robot, ground, gait, rtol=1e-9)
    for rtol in (1e-2, 1e-4, 1e-5):
        s = sn.steady_gait(robot, ground, gait, rtol=rtol)
        assert abs(s.speed_m_s / truth.speed_m_s - 1) < s.error_estimate
        assert s.settling_time_s == pytest.approx(truth.settling_time_s, rel=s.settling_error)
