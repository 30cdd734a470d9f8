"""Periodic states: published values, independent references, symmetry, limits, error estimates."""

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
    state = sn.steady_gait(PAPER, VISCOUS, gait_in_deg(30, 80, 5), rtol=1e-9)
    assert state.speed_m_s == pytest.approx(0.292060796024, rel=2e-12)
    assert state.power_w == pytest.approx(0.073312554830, rel=2e-11)
    # Seven digits are published.
    assert state.abs_power_w == pytest.approx(0.5146735, rel=1e-7)
    assert state.positive_power_w == pytest.approx(0.2939930, rel=1e-7)


def test_the_robot_of_2005() -> None:
    state = sn.steady_gait(OF_2005, BINGHAM, gait_in_deg(70, 75, 5))
    assert state.speed_m_s == pytest.approx(0.133205, rel=4e-6)
    slow = sn.steady_gait(OF_2005, BINGHAM, gait_in_deg(70, 75, 1))
    assert slow.speed_m_s == pytest.approx(0.03317, rel=2e-4)


@pytest.mark.parametrize("ground", [VISCOUS, BINGHAM], ids=["viscous", "dry"])
def test_a_run_converges_to_the_periodic_state(ground: sn.Ground) -> None:
    """From another start the motion converges at the rate of the largest multiplier."""
    gait = gait_in_deg(60, 75, 6)
    state = sn.steady_gait(OF_2005, ground, gait, rtol=1e-7)
    cycles = math.ceil(12 * state.settling_time_s / gait.period_s) + 2
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
    # exp(-12) = 6e-6 of the start remains; the error of RK4 with 400 steps a period is 1e-8.
    assert speeds[-1] == pytest.approx(state.speed_m_s, rel=2e-5)
    assert abs(speeds[0] / state.speed_m_s - 1) > 1e-2


def test_an_answer_above_the_tolerance_is_in_the_exception() -> None:
    """Two heavy links at 21 cycles a second, so that friction hardly acts."""
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
    # The estimate is relative to the speed, or to this least scale. Most tolerances give 1.599e-4.
    scale_m_s = max(best.speed_m_s, 1e-4 * 2 * robot.link_length_m * gait.omega_rad_s)
    assert abs(best.speed_m_s - 1.599221e-4) < best.error_estimate * scale_m_s


def test_speed_and_radius_of_a_turning_gait_do_not_depend_on_the_phase() -> None:
    """Mirror images differ by half a cycle: equal circles, but different chords."""
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
    # The mean position over a cycle moves on the circle, here from 64 x 40 positions.
    position = (run.x_m.mean(axis=1) + 1j * run.y_m.mean(axis=1))[:-1].reshape(40, 64)
    turned = np.exp(1j * left.turn_rad_per_cycle * np.arange(40))
    step = np.diff(position, axis=0) / turned[:-1, None]  # equal in all cycles, for each phase
    back = np.exp(-1j * left.turn_rad_per_cycle * np.arange(64) / 64)
    centre_to_position = (step / (turned[1] - 1)).mean(axis=0)
    assert abs((centre_to_position * back).mean()) == pytest.approx(left.radius_m, rel=1e-6)


def rows(name: str) -> list[dict[str, str]]:
    """Return the rows of a reference table; an empty table is an error of collection."""
    with (REFERENCE / name).open(newline="") as file:
        table = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert table, f"{name} holds no row"
    return table


def test_power_without_motion_and_without_travel() -> None:
    still = sn.steady_gait(PAPER, VISCOUS, sn.Gait(0.0, 1.0, 3.0))
    assert still.speed_m_s < 1e-12
    assert still.power_w < 1e-12
    for ground in (VISCOUS, BINGHAM):  # equal phases: no travel, by symmetry
        state = sn.steady_gait(OF_2005, ground, sn.Gait(0.5, 0.0, 3.0))
        assert state.power_w > 0


@pytest.mark.parametrize("row", rows("periodic_viscous.csv"), ids=lambda r: r["links"])
def test_viscous_reference_table(row: dict[str, str]) -> None:
    """The table is from other code: shooting in velocities, adaptive quadrature of |P|."""
    values = {name: float(text) for name, text in row.items()}
    robot = sn.Robot(
        int(values["links"]),
        values["mass_kg"],
        2 * values["half_length_m"],
        values["inertia_kg_m2"],
    )
    gait = sn.Gait(
        values["alpha_rad"], values["beta_rad"], values["omega_rad_s"], values["offset_rad"]
    )
    state = sn.steady_gait(robot, sn.Ground(values["ct"], values["cn"]), gait, rtol=1e-9)
    size = gait.omega_rad_s * robot.link_length_m * robot.links
    # The error of the table is some 1e-12 of the scale of the motion.
    assert state.chord_m_s == pytest.approx(values["speed_m_s"], rel=1e-9, abs=1e-12 * size)
    assert state.turn_rad_per_cycle == pytest.approx(
        values["turn_rad_per_cycle"], rel=1e-9, abs=1e-10
    )
    assert state.power_w == pytest.approx(values["power_w"], rel=1e-9)
    assert state.abs_power_w == pytest.approx(values["abs_power_w"], rel=1e-7)
    assert state.positive_power_w == pytest.approx(values["positive_power_w"], rel=1e-7)
    assert state.positive_power_error_w <= 1e-6 * state.positive_power_w
    slowest = abs(complex(values["multiplier1_re"], values["multiplier1_im"]))
    assert abs(state.floquet_multipliers[0]) == pytest.approx(slowest, rel=1e-6, abs=1e-9)


def test_error_estimates_of_a_motion_that_settles_slowly() -> None:
    """The motion settles in 20 000 cycles, which add up the error of one cycle."""
    robot = sn.Robot(34, 8.603133192418403, 0.01841195261926163)
    ground = sn.Ground(0.00011684949643648431, 0.0007194612325834184)
    gait = sn.Gait(1.1663787066988576, 0.26832900909664276, 5.495101313332529)
    truth = sn.steady_gait(robot, ground, gait, rtol=1e-9)
    for rtol in (1e-2, 1e-4, 1e-5):
        state = sn.steady_gait(robot, ground, gait, rtol=rtol)
        assert abs(state.speed_m_s / truth.speed_m_s - 1) < state.error_estimate
        assert state.settling_time_s == pytest.approx(
            truth.settling_time_s, rel=state.settling_error
        )
