"""A short film with the fitted chain drawn into its frames."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from ..base.files import whole_file
from .arrays import Array
from .fitting.camera import Camera
from .measure_film import FilmMeasurement
from .seeing.film import Damage

LONGEST_S = 20.0
WIDEST_PX = 1280
CHAIN, JOINT, PATH = (40, 60, 235), (0, 200, 255), (220, 150, 0)  # blue, green, red
TICKS_S = Fraction(1, 90000)


def annotate_film(measured: FilmMeasurement, path: Path) -> None:
    """Write the film's first LONGEST_S seconds with chain, path and numbers, as H.264."""
    import av
    import cv2

    camera, track = measured.measured.bundle.camera, measured.measured.track
    film = measured.watched.film
    shrink = max(1, math.ceil(film.width / WIDEST_PX))
    size = (film.width // shrink // 2 * 2, film.height // shrink // 2 * 2)
    begun, hertz = track.t_s[0], measured.run.omega_rad_s / math.tau
    # The film's own times: where those of the track are the board's, frames are counted in them.
    times = begun + (track.t_s - begun) * film.time_scale / measured.run.time_scale
    with whole_file(path) as part, av.open(str(part), "w") as box:
        stream: Any = box.add_stream("libx264", rate=30)
        turns = measured.watched.rotation_deg // 90
        stream.width, stream.height = size[::-1] if turns % 2 else size
        stream.pix_fmt = "yuv420p"
        stream.time_base = stream.codec_context.time_base = TICKS_S
        for time_s, grey, _ in film.frames(Damage()):
            if time_s > begun + LONGEST_S:
                break
            picture = cv2.cvtColor(np.ascontiguousarray(grey), cv2.COLOR_GRAY2BGR)
            k = int(np.searchsorted(times, time_s - 1e-6))
            if k < len(times) and abs(times[k] - time_s) < 1e-4:
                _draw(picture, camera, track.states, k)
            picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
            picture = np.ascontiguousarray(np.rot90(picture, turns))
            text = f"{time_s:6.2f} s   {1e3 * measured.run.speed_m_s:.1f} mm/s   {hertz:.3f} Hz"
            low = picture.shape[0]
            cv2.rectangle(picture, (0, low - 40), (400, low), (0, 0, 0), -1)
            where = (12, low - 14), cv2.FONT_HERSHEY_SIMPLEX, 0.6
            cv2.putText(picture, text, *where, (255, 255, 255), 1, cv2.LINE_AA)
            frame = av.VideoFrame.from_ndarray(picture, format="bgr24").reformat(format="yuv420p")
            frame.pts, frame.time_base = round(time_s / TICKS_S), TICKS_S
            box.mux(stream.encode(frame))
        box.mux(stream.encode())


def _draw(picture: Any, camera: Camera, states: Array, k: int) -> None:
    import cv2

    joints, path = (
        places.round().astype(np.int32)
        for places in (camera.joints_px(states[k]), camera.plane_px(states[: k + 1, :2]))
    )
    thick = max(2, picture.shape[1] // 500)
    cv2.polylines(picture, [path], False, PATH, thick, cv2.LINE_AA)
    cv2.polylines(picture, [joints], False, CHAIN, thick, cv2.LINE_AA)
    for joint in joints.tolist():
        cv2.circle(picture, joint, 2 * thick, JOINT, -1, cv2.LINE_AA)
