"""The environment holds to Gymnasium's rules, and a wave of torques crawls in it."""

from __future__ import annotations

import warnings

import numpy as np
import serpenoid as sn
from gymnasium.utils.env_checker import check_env
from serpenoid.exchange.gym_env import SnakeEnv


def test_gymnasiums_own_check() -> None:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*(infinity|symmetric|precision).*")
        check_env(SnakeEnv(episode_s=0.2), skip_render_check=True)


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


def test_the_same_seed_is_the_same_episode() -> None:
    seen = []
    for _ in range(2):
        env = SnakeEnv(ground=sn.Ground(0.014, 0.2, 0.02, 0.04))
        first, _ = env.reset(seed=7)
        seen.append((first, env.step(np.full(5, 0.5, np.float32))[0]))
    assert np.array_equal(seen[0][0], seen[1][0])
    assert np.array_equal(seen[0][1], seen[1][1])


def test_a_folded_joint_and_a_late_hour_end_an_episode() -> None:
    env = SnakeEnv(torque_nm=1.0, episode_s=0.04)
    env.reset(seed=1)
    assert not env.step(np.zeros(5, np.float32))[3]
    assert env.step(np.zeros(5, np.float32))[3]
    assert any(env.step(np.ones(5, np.float32))[2] for _ in range(30))
