"""Measure rendered films of known robots: errors, and how many of the stated intervals hold them.

python studies/films.py plain --films 216 --seed 3   some 3 s of processor time a film
python studies/films.py worlds --films 8        the hard worlds, 8 films each
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
from serpenoid import BadInput
from serpenoid.video.measure_film import measure_film
from serpenoid.video.result import FilmMeasurement
from video.filming import Body, Film, Glare, Lens, write
from video.worlds import LINK_M, World, crawling

NORMAL_95 = 1.96
Errors = dict[str, np.ndarray]

WIDE_PX = 2000  # a film as wide as this is drawn with fewer samples a pixel, for its time


@dataclass(frozen=True)
class Scene:
    """One film: a robot that crawls, tags on it, a camera; steps: moments in an exposure."""

    world: World
    body: Body
    lens: Lens
    seconds: float
    steps: int = 1
    glare: Glare | None = None


def plain(rng: np.random.Generator, links: int = 6, tilt_deg: float | None = None) -> Scene:
    """Return a scene as a person may film it: 2 to 2.5 periods, tags of some 30 px, 640 px wide."""
    omega = rng.uniform(6.5, 9.0)
    speed = rng.uniform(0.04, 0.1)
    seconds = rng.uniform(2.05, 2.5) * math.tau / omega
    world = crawling(
        int(rng.integers(1 << 30)),
        links,
        speed,
        rng.uniform(28, 45),
        omega,
        -0.5 * speed * seconds,
    )
    body = Body(
        links,
        mount_m=rng.normal(size=(links, 3)) * [0.002, 0.002, 0.001],
        turn_rad=np.radians(1.5) * rng.normal(size=links),
        slope=0.02 * rng.normal(size=(links, 2)),
    )
    tilt = math.radians(rng.uniform(5, 45) if tilt_deg is None else tilt_deg)
    around, distance_m = rng.uniform(0, math.tau), rng.uniform(0.7, 1.2) * links / 6
    eye = distance_m * np.array(
        [math.sin(tilt) * math.cos(around), math.sin(tilt) * math.sin(around), math.cos(tilt)]
    )
    lens = Lens(
        tuple(eye + np.array([0, 0, body.height_m])),
        (0.0, 0.0, body.height_m),
        2 * round(320 * max(1, links / 6)),
        2 * round(240 * max(1, links / 6)),
        rng.uniform(26, 31) / body.side_m * distance_m,
        k1=rng.uniform(-0.1, 0.1),
        k2=rng.uniform(-0.03, 0.03),
        middle_px=tuple(3 * rng.normal(size=2)),
        rolling_s=rng.uniform(0, 0.02),
        noise=rng.uniform(1, 3),
    )
    return Scene(world, body, lens, seconds)


def larger(scene: Scene, factor: float) -> Scene:
    """Return a scene in a picture of so many times the pixels a side."""
    lens = scene.lens
    x, y = lens.middle_px
    return replace(
        scene,
        lens=replace(
            lens,
            width=2 * round(lens.width * factor / 2),
            height=2 * round(lens.height * factor / 2),
            focal_px=lens.focal_px * factor,
            middle_px=(x * factor, y * factor),
        ),
    )


def slow_shutter(rng: np.random.Generator) -> Scene:
    """Return a scene with 1/30 s of exposure, 25 ms of readout, seen 48 degrees aslant."""
    scene = larger(plain(rng, tilt_deg=48), 1.5)
    world = crawling(int(rng.integers(1 << 30)), 6, 0.05, 35.0, 4.5, -0.08)
    lens = replace(scene.lens, exposure_s=1 / 30, rolling_s=0.025)
    return replace(scene, world=world, lens=lens, seconds=2.2 * math.tau / 4.5, steps=8)


def glare(rng: np.random.Generator) -> Scene:
    """Return a scene with a lamp's reflection that hides some three tags in ten."""
    place = rng.uniform(-0.08, 0.08), rng.uniform(-0.02, 0.02)
    return replace(plain(rng), glare=Glare(place, rng.uniform(0.05, 0.07)))


WORLDS: dict[str, Callable[[np.random.Generator], Scene]] = {
    "plain": plain,
    "48 degrees": lambda rng: larger(plain(rng, tilt_deg=48), 1.3),
    "slow shutter": slow_shutter,
    "glare": glare,
    "4 links": lambda rng: plain(rng, 4),
    "10 links": lambda rng: plain(rng, 10),
    "15 px": lambda rng: larger(plain(rng), 0.53),
    "10 links, 15 px": lambda rng: larger(plain(rng, 10), 0.53),
    "20 px": lambda rng: larger(plain(rng), 0.72),
    "4k": lambda rng: larger(plain(rng), 6),
}


def shot(scene: Scene, path: Path, seed: int) -> Path:
    """Render a scene into a file, at a phone's varying times."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(0, scene.seconds, 1 / 30)
    t_s = t_s + 0.001 * rng.normal(size=len(t_s))
    camera = Film(
        scene.lens,
        scene.body,
        scene.world.pose,
        seed,
        scene.glare,
        steps=scene.steps,
        up=3 if scene.lens.width < WIDE_PX else 2,
    )
    return write(path, [camera.frame(t) for t in t_s], t_s - t_s[0])


def errors(measurement: FilmMeasurement, world: World) -> tuple[Errors, Errors]:
    """Return the numbers' errors, in % and degrees, and the same in their standard deviations."""
    run = measurement.run

    def of_joints(name: str) -> np.ndarray:
        return np.array([getattr(joint, name) for joint in run.joints])

    lag_error = of_joints("phase_rad") - world.phase_rad + world.phase_rad[0]
    deviation = {
        "amplitude": of_joints("amplitude_rad") - world.amplitude_rad,
        "phase": (lag_error[1:] + math.pi) % math.tau - math.pi,
        "centre": of_joints("offset_rad") - world.offset_rad,
        "turn": np.array([run.turn_rad_s - world.turn_rad_s]),
        "speed": np.array([run.speed_m_s - world.speed_m_s]),
        "rate": np.array([run.omega_rad_s - world.omega_rad_s]),
    }
    sigma = {
        "amplitude": of_joints("amplitude_sigma_rad"),
        "phase": of_joints("phase_sigma_rad")[1:],
        "centre": of_joints("offset_sigma_rad"),
        "turn": run.turn_sigma_rad_s,
        "speed": run.speed_sigma_m_s,
        "rate": run.omega_sigma_rad_s,
    }
    size = {name: np.degrees(error) for name, error in deviation.items()}
    for name, true in (("speed", world.speed_m_s), ("rate", world.omega_rad_s)):
        size[name] = 100 * deviation[name] / true
    return size, {name: error / sigma[name] for name, error in deviation.items()}


def measured(world: str, films: int, seed: int) -> Iterator[tuple[Errors, Errors]]:
    """Render and measure films of a world; those that are refused are told."""
    with tempfile.TemporaryDirectory() as folder:
        for k in range(films):
            scene = WORLDS[world](np.random.default_rng([seed, k]))
            path = shot(scene, Path(folder) / "film.mp4", k)
            try:
                measurement = measure_film(path, scene.body.links, LINK_M)
            except BadInput as error:
                print(f"{world} {k}: refused: {str(error)[len(str(path)) :]}", flush=True)
                continue
            size, z = errors(measurement, scene.world)
            lost = 1 - measurement.watched.sightings.visible.mean()
            print(
                f"{world} {k}: {len(measurement.measured.track.t_s)} frames, "
                f"{100 * lost:.0f} % of the tags lost, "
                f"speed {size['speed'][0]:+.3f} % ({z['speed'][0]:+.1f} sigma), "
                f"amplitude {np.abs(size['amplitude']).max():.2f}, "
                f"phase {np.abs(size['phase']).max():.2f} degrees",
                flush=True,
            )
            yield size, z


def summary(films: list[tuple[Errors, Errors]]) -> str:
    """Return a table: median and worst error, share inside 95 %, the root mean square in sigmas."""
    lines = [f"{len(films)} films    median   worst   inside 95 %   rms in sigmas"]
    for name in films[0][0]:
        size = np.concatenate([size[name] for size, _ in films])
        z = np.concatenate([z[name] for _, z in films])
        inside, doubt = (np.abs(z) < NORMAL_95).mean(), math.sqrt(0.05 * 0.95 / max(1, len(z)))
        lines.append(
            f"{name:10} {np.median(np.abs(size)):8.4f} {np.abs(size).max():8.3f}"
            f"   {100 * inside:5.1f} ± {100 * doubt:.1f} %   {math.sqrt(np.mean(z**2)):.2f}"
        )
    return "\n".join(lines)


def main() -> None:
    """Measure films of one world, or of each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("world", choices=[*WORLDS, "worlds"])
    parser.add_argument("--films", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    for world in list(WORLDS)[1:] if arguments.world == "worlds" else [arguments.world]:
        films = list(measured(world, arguments.films, arguments.seed))
        if films:
            print(f"{world}: {summary(films)}\n", flush=True)


if __name__ == "__main__":
    main()
