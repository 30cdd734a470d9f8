"""Sessions of pushes for tests: rolled out by an integration of their own, no code of the package.

The slow truth: v' = -(A v + B) / m_e in steps of 0.1 ms, stopped where the speed passes 0.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from serpenoid.taking.new_session import default_setup
from simulated_sessions import MemoryRecord

FT0, TRUTH = 0.14, (0.084, 1.2, 0.14, 0.27)
MASS, G, STEP_S = 6 * 0.0756, 9.80665, 1e-4
WHEELS_KG = 0.036
NEW = "calibrate new --defaults --on floor --surface parquet --mass-kg 0.454"


def floor_setup(wheels_kg=WHEELS_KG, **instruments):
    base = default_setup("floor")
    plan = replace(base.plan, on="floor", gaits=())
    tools = replace(base.instruments, **({"joint_sigma_deg": 0.0} | instruments))
    body = replace(base.robot_table, wheels_kg=wheels_kg)
    return replace(base, robot_table=body, plan=plan, instruments=tools)


def forces(whole, bend_rad, rolling):
    """Slope, dry force and inert mass, link by link, of + - 0 0 - +."""
    ct, cn, ft0, fn0 = whole
    slope = dry = inert = 0.0
    for sign in (1, -1, 0, 0, -1, 1):
        c, s = math.cos(sign * bend_rad), abs(math.sin(sign * bend_rad))
        slope += (ct * c * c + cn * s * s) / 6
        dry += (ft0 * c + fn0 * s) / 6
        inert += MASS * (1 + rolling * c * c) / 6
    return slope, dry, inert


def rolled_out(v0, whole, bend_rad=0.0, slope_rad=0.0, rolling=0.0):
    """Return times and ways until 0.4 s after it rests, by the midpoint rule."""
    a, b, inert = forces(whole, bend_rad, rolling)
    pull = b - MASS * G * math.sin(slope_rad)
    v, x, ways = v0, 0.0, [0.0]
    while v > 0.0:
        half = v - STEP_S / 2 * (a * v + pull) / inert
        after = v - STEP_S * (a * half + pull) / inert
        x += STEP_S * half if after > 0.0 else v * v * inert / (2 * (a * v + pull))
        v = after
        ways.append(x)
    ways += [x] * 4000
    return STEP_S * np.arange(len(ways)), np.array(ways)


def push_track(v0, whole, rng, sigma_m=0.001, direction_rad=0.3, **world):
    """Return samples t, x, y of 30 pictures a second."""
    t, way = rolled_out(v0, whole, **world)
    at = np.arange(0.011, t[-1], 1 / 30)
    along = np.interp(at, t, way)
    x = along * math.cos(direction_rad) + sigma_m * rng.normal(size=len(at))
    y = along * math.sin(direction_rad) + sigma_m * rng.normal(size=len(at))
    return np.stack([at, x, y], axis=1)


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
