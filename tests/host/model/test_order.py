"""Robot, ground and gait in a wrong order are named, wherever they are taken."""

from __future__ import annotations

import pytest
import serpenoid as sn
from refusals import refused
from robots import PAPER, VISCOUS

GAIT = sn.Gait(0.5, 1.4, 5.0)
ONE = {"alpha_rad": 0.5, "beta_rad": 1.4, "omega_rad_s": 5.0}


@pytest.mark.parametrize(
    "call",
    [
        lambda: sn.steady_gait(PAPER, GAIT, VISCOUS),
        lambda: sn.simulate(sn.Scene(PAPER, GAIT, VISCOUS)),
        lambda: sn.sweep(PAPER, GAIT, **ONE),
        lambda: sn.least_power_gait(PAPER, GAIT, speed_m_s=0.1),
        lambda: sn.steady_springs(PAPER, GAIT, VISCOUS),
    ],
    ids=["steady_gait", "scene", "sweep", "least_power_gait", "steady_springs"],
)
def test_ground_and_gait_exchanged(call) -> None:
    with refused(r"ground is a Gait; .* robot, ground, gait"):
        call()


def test_robot_last() -> None:
    with refused("robot is a Ground"):
        sn.steady_gait(VISCOUS, PAPER, GAIT)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: sn.simulate(PAPER), "scene is a Robot; it must be a serpenoid.Scene"),
        (lambda: sn.fit_friction("my-robot"), "session is a str; it must be a serpenoid.Session"),
        (lambda: sn.compare("my-robot"), "session is a str"),
        (lambda: sn.advise(GAIT), "session is a Gait"),
        (lambda: sn.acceleration(VISCOUS, PAPER, None), "robot is a Ground"),
        (lambda: sn.acceleration(PAPER, VISCOUS, None), "state is a NoneType"),
    ],
)
def test_another_kind_is_named(call, said) -> None:
    with refused(said):
        call()
