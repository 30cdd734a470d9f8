"""The environment holds to Gymnasium's rules, and a wave of torques crawls in it."""

from __future__ import annotations

import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
import serpenoid as sn
from gymnasium.utils.env_checker import check_env
from refusals import refused
from serpenoid import LinkState, StepTooLarge
from serpenoid.exchange.gym_env import SnakeEnv
from serpenoid.exchange.picture import GROUND, HEAD, LINK, picture


def test_gymnasiums_own_check() -> None:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*(infinity|symmetric|precision).*")
        env = gymnasium.make("serpenoid/Snake-v0", episode_s=0.2, render_mode="rgb_array")
        check_env(env.unwrapped)


def test_the_name_alone_imports_the_module() -> None:
    program = (
        "import gymnasium; env = gymnasium.make('serpenoid.exchange.gym_env:serpenoid/Snake-v0'); "
        "print(env.reset(seed=1)[0].shape)"
    )
    assert subprocess.check_output([sys.executable, "-c", program], text=True) == "(15,)\n"


def crawl(beta_rad: float, alpha_rad: float = 0.6) -> float:
    """Return how far springs that pull the joints towards a gait bring the snake along x."""
    env = SnakeEnv(torque_nm=0.1)
    seen, _ = env.reset(seed=3)
    way_m = 0.0
    for k in range(250):
        wanted = alpha_rad * np.sin(5.0 * k * env.control_s + beta_rad * np.arange(5))
        pull = (0.04 * (wanted - seen[5:10]) - 0.001 * seen[10:]) / env.torque_nm
        seen, _, ended, _, told = env.step(np.clip(pull, -1, 1).astype(np.float32))
        assert not ended
        way_m += told["way_m"]
    return way_m


def test_a_wave_crawls_both_ways_and_stillness_does_not() -> None:
    one, other = crawl(1.4), crawl(-1.4)
    assert one * other < 0
    assert min(abs(one), abs(other)) > 0.1
    assert abs(crawl(1.4, alpha_rad=0.0)) < 0.01


def test_a_folded_joint_and_a_late_hour_end_an_episode() -> None:
    env = SnakeEnv(torque_nm=1.0, episode_s=0.04)
    env.reset(seed=1)
    assert not env.step(np.zeros(5, np.float32))[3]
    assert env.step(np.zeros(5, np.float32))[3]
    assert any(env.step(np.ones(5, np.float32))[2] for _ in range(30))


@pytest.mark.parametrize(
    "wrong",
    [
        {"torque_nm": "1"},
        {"control_s": float("nan")},
        {"control_s": -1.0},
        {"episode_s": 0.0},
        {"work_cost_m_j": float("nan")},
        {"robot": 6},
        {"ground": "wet"},
        {"dt_s": 0.0},
        {"dt_s": 1e-12},
        {"render_mode": "human"},
    ],
)
def test_wrong_arguments_are_refused_in_words(wrong) -> None:
    with refused(next(iter(wrong))):
        SnakeEnv(**wrong)


@pytest.mark.parametrize(
    "action", ["ones", ["a"] * 5, [1.0, 2.0], [float("nan")] * 5, [10**400] * 5, [1j] * 5, None]
)
def test_a_wrong_action_is_refused_in_words(action) -> None:
    env = SnakeEnv()
    env.reset(seed=1)
    with refused("action"):
        env.step(action)


def test_ground_too_stiff_for_the_step_names_an_argument_that_helps() -> None:
    ground = sn.Ground(1e3, 1e4)
    env = SnakeEnv(ground=ground)
    env.reset(seed=1)
    with pytest.raises(StepTooLarge, match="take dt_s 1e-05"):
        env.step(np.ones(5, np.float32))
    env = SnakeEnv(ground=ground, dt_s=1e-5)
    env.reset(seed=1)
    env.step(np.ones(5, np.float32))


def test_a_picture_shows_each_link_where_it_is() -> None:
    robot = sn.Robot(4, 0.1, 0.1)
    state = LinkState.joined(robot, [3.0, -2.0, 0.0, 0.5, 1.0, 1.5], np.zeros(6))
    seen = picture(robot, state)
    for link in range(4):
        column = 299.5 + (state.x_m[link] - state.x_m.mean()) / 0.8 * 600
        row = 149.5 - (state.y_m[link] - state.y_m.mean()) / 0.8 * 600
        assert np.array_equal(seen[round(row), round(column)], HEAD if link == 3 else LINK)
    assert np.array_equal(seen[5, 7], GROUND)  # between the lines of the grid


def test_no_picture_unless_asked_for() -> None:
    assert SnakeEnv().render() is None
