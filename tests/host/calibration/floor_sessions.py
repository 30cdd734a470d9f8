"""Sessions of pushes for tests: by the lab's rigid body, which shares no formula with the fit."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from serpenoid import Ground
from serpenoid.lab.floor import Floor, Push
from serpenoid.lab.recording import Camera, film
from serpenoid.lab.robot import LabRobot, pose_of
from serpenoid.model.bends import balanced_signs
from serpenoid.taking.new_session import default_setup
from simulated_sessions import MemoryRecord

FT0, TRUTH = 0.14, (0.084, 1.2, 0.14, 0.27)
MASS = 6 * 0.0756
WHEELS_KG = 0.036
NEW = "calibrate new --defaults --on floor --surface parquet --mass-kg 0.454"


def floor_setup(wheels_kg=WHEELS_KG, **instruments):
    base = default_setup("floor")
    plan = replace(base.plan, on="floor", gaits=())
    tools = replace(base.instruments, **({"joint_sigma_deg": 0.0} | instruments))
    body = replace(base.robot_table, wheels_kg=wheels_kg)
    return replace(base, robot_table=body, plan=plan, instruments=tools)


def push_track(
    v0, whole, rng, sigma_m=0.001, direction_rad=0.3, bend_rad=0.0, slope_rad=0.0, rolling=0.0
):
    """Return samples t, x, y of 30 pictures a second; slope_rad: by which it rolls downhill."""
    body = floor_setup().robot
    robot = LabRobot.whole_body(body, Ground(*whole), rolling_kg=rolling * MASS)
    track = Floor(robot, slope_rad).push(pose_of(balanced_signs(6), bend_rad), Push(v0))
    rows = film(track, Camera(sigma_m=sigma_m), rng)
    t, x, y = rows[rows[:, 0] > track.released_s, :3].T
    c, s = math.cos(direction_rad), math.sin(direction_rad)
    return np.stack([t - t[0], c * x - s * y, s * x + c * y], axis=1)


def floor_session(
    seed=1,
    *,
    slope_rad=0.003,
    rolling=0.0595,
    bends_deg=(0.0, 20.0, 45.0),
    speeds=(0.6, 0.7, 0.9, 1.0),
    sigma_m=0.001,
    ways=("there", "back"),
    setup=None,
):
    """Take a session of filmed pushes; rolling 0.75 * 36 g / 454 g."""
    rng = np.random.default_rng(seed)
    record = MemoryRecord(setup or floor_setup())
    for bend in bends_deg:
        for k, v0 in enumerate(speeds):
            way = ways[k % len(ways)]
            track = push_track(
                v0,
                TRUTH,
                rng,
                sigma_m,
                bend_rad=math.radians(bend),
                rolling=rolling,
                direction_rad=0.3 if way == "there" else 0.3 + math.pi,
                slope_rad=slope_rad * (1 if way == "there" else -1),
            )
            cells = {
                "lambda_deg": bend,
                "bend": "balanced",
                "way": way,
                "by": "film",
                "distance_sigma_m": sigma_m,
            }
            record.add("push", cells, samples=track)
    return record.session


short_session = partial(floor_session, bends_deg=(0.0, 45.0), speeds=(0.7, 0.9))
