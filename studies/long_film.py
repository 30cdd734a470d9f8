"""Measure a film of many minutes: processor time and memory, from the file to its numbers.

python studies/long_film.py --minutes 10        one rendered cycle, its packets written again
"""

from __future__ import annotations

import argparse
import math
import resource
import sys
import tempfile
import time
from pathlib import Path

import av
import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "host"))
from serpenoid.video.measure_film import measure_film
from video.filming import Body, Film, Lens, write
from video.worlds import LINK_M, crawling

RATE_HZ, FRAMES, CYCLES = 30, 90, 2


def cycle(path: Path) -> Path:
    """Render a robot that undulates on the spot, and ends as it began."""
    world = crawling(omega_rad_s=math.tau * CYCLES * RATE_HZ / FRAMES, speed_m_s=0.0, start_m=0.0)

    def pose(t_s: float) -> tuple[np.ndarray, np.ndarray]:
        centre, theta = world.pose(t_s)
        back = np.exp(-1j * world.turn_rad_s * t_s)
        turned = (centre[:, 0] + 1j * centre[:, 1]) * back
        return np.column_stack([turned.real, turned.imag]), theta - world.turn_rad_s * t_s

    t_s = np.arange(FRAMES) / RATE_HZ
    film = Film(Lens(), Body(), pose)
    return write(path, [film.frame(t) for t in t_s], t_s)


def repeated(source: Path, path: Path, times: int) -> Path:
    """Write a film's packets many times, one after the other."""
    with av.open(str(source)) as old, av.open(str(path), "w") as new:
        stream = old.streams.video[0]
        packets = [packet for packet in old.demux(stream) if packet.dts is not None]
        stamps = [(packet.pts, packet.dts) for packet in packets]
        length = round(FRAMES / RATE_HZ / packets[0].time_base)
        out = new.add_stream_from_template(stream)
        for k in range(times):
            for packet, (pts, dts) in zip(packets, stamps, strict=True):
                packet.pts, packet.dts = pts + k * length, dts + k * length
                packet.time_base, packet.stream = stream.time_base, out
                new.mux(packet)
    return path


def main() -> None:
    """Measure a film of so many minutes; tell frames, processor time, memory, and the numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10)
    minutes = parser.parse_args().minutes
    with tempfile.TemporaryDirectory() as folder:
        short = cycle(Path(folder) / "cycle.mp4")
        path = repeated(short, Path(folder) / "long.mp4", round(60 * minutes * RATE_HZ / FRAMES))
        before = time.process_time()
        found = measure_film(path, 6, LINK_M)
        used = time.process_time() - before
    frames = len(found.measured.track.t_s)
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{frames} frames: {used:.0f} s of processor time, {1e3 * used / frames:.1f} ms a frame, "
        f"{peak_mb:.0f} MB at most; rate {found.run.omega_rad_s:.5f} rad/s"
    )


if __name__ == "__main__":
    main()
