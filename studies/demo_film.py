"""Film the lab's robot for the demo: firmware's set-points, servos, floor, pixels, and the truth.

python studies/demo_film.py         writes calibration_data/demo-film, some 10 s
"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import serpenoid as sn

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
from serpenoid.lab.robot import LabRobot
from video.filming import Body, Lens
from video.lab_world import Servos, setpoints, simulated_world
from video.worlds import World, shoot

FOLDER = Path(__file__).parent.parent / "calibration_data" / "demo-film"
GAIT = sn.Gait(math.radians(60), math.radians(75), math.tau / 1.2)
LENS = Lens(
    (0.4, -0.42, 0.72), (0.315, 0.0, 0.045), 720, 400, 740, 0.06, -0.02, (4, -3), 0.006, 0.015
)
SECONDS = 2.2 * GAIT.period_s


def world() -> World:
    """Return the demo's robot on its ground; its servos lag and miss the commanded angle."""
    rng = np.random.default_rng(2005)
    whole_robot = LabRobot.whole_body(sn.Robot(6, 0.0756, 0.076), sn.Ground(0.084, 1.2, 0.14, 0.27))
    robot = whole_robot.drawn(rng, math.radians(1.5), 0.1)
    servos = Servos(rng.uniform(0.02, 0.035, 5), rng.uniform(0.9, 0.97, 5))
    return simulated_world(robot, servos, GAIT, setpoints(GAIT, 8.0))


def truth(film_world: World) -> dict[str, Any]:
    """Return the commanded gait, and what the lab knows, in SI units."""
    return {
        "alpha_rad": GAIT.alpha_rad,
        "beta_rad": GAIT.beta_rad,
        "omega_rad_s": GAIT.omega_rad_s,
        "links": film_world.links,
        "link_length_m": 0.076,
        "speed_m_s": film_world.speed_m_s,
        "turn_rad_s": film_world.turn_rad_s,
        "amplitude_rad": film_world.amplitude_rad.tolist(),
        "phase_rad": (film_world.phase_rad - film_world.phase_rad[0]).tolist(),
    }


def main() -> None:
    """Write film and truth."""
    FOLDER.mkdir(exist_ok=True)
    film_world, rng = world(), np.random.default_rng(7)
    body = Body(
        6,
        mount_m=rng.normal(size=(6, 3)) * [0.002, 0.002, 0.001],
        turn_rad=np.radians(1.5) * rng.normal(size=6),
        slope=0.02 * rng.normal(size=(6, 2)),
    )
    shoot(film_world, FOLDER / "film.mp4", LENS, body, SECONDS, crf=24)
    (FOLDER / "truth.json").write_text(json.dumps(truth(film_world), indent=2) + "\n")


if __name__ == "__main__":
    main()
