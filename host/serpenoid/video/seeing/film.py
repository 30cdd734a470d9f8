"""A film file: its frames as grey pictures, one after the other, with the file's own times."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import BadInput
from ...base.files import check_file
from ...model.capture_rate import OPTION, CaptureRate, capture_rate
from ..arrays import Grey
from .extra import need_extra


@dataclass(frozen=True)
class Film:
    """What the file says of itself; frames() reads it.

    width, height: of the coded picture, px, before any rotation. duration_s: in real time, 0 where
    the file does not tell. capture: the camera's rate and that of the file,
    None where nothing tells the former.
    """

    path: Path
    width: int
    height: int
    duration_s: float
    capture: CaptureRate | None = None

    @property
    def time_scale(self) -> float:
        """Return what the file's times are multiplied with to be real ones."""
        return 1.0 if self.capture is None else self.capture.time_scale

    @staticmethod
    def open(path: Path, capture_fps: float | None) -> Film:
        """Read what the file says. Raises BadInput: no film, or damaged.

        capture_fps: pictures a second that the camera took, where somebody says so; else what the
        file's tag says.
        """
        need_extra()
        import av
        import av.error

        check_file(path, 1 << 40)
        try:
            with av.open(str(path)) as box:
                stream = box.streams.best("video")
                coding = stream and stream.codec_context
                if stream is None or coding is None:
                    raise ValueError("no pictures in it, or of an unknown coding")
                duration_s = float(box.duration or 0) / 1e6
                tags = {**box.metadata, **stream.metadata}
                rates = {
                    f"the tag {name}": float(text)
                    for name, text in tags.items()
                    if name.endswith("capture.fps") and re.fullmatch(r"[\d.]+", text)  # Android's
                }
                if capture_fps is not None:
                    rates = {OPTION: capture_fps}
                film = Film(path, coding.width, coding.height, duration_s)
                if not rates:
                    return film
                times_s = [_time_s(packet) for packet in box.demux(stream)]
        except (av.error.FFmpegError, ValueError) as error:
            words = str(getattr(error, "strerror", None) or error)
            raise BadInput(
                f"{path}: cannot be read as a film ({words}); copy it from the phone again, as MP4 "
                "or MOV"
            ) from error
        source, taken_hz = next(iter(rates.items()))
        capture = capture_rate(np.array(times_s)[np.isfinite(times_s)], taken_hz, source)
        return replace(film, duration_s=duration_s * capture.time_scale, capture=capture)

    def frames(self) -> Iterator[tuple[float, Grey]]:
        """Give time (s) and grey picture, in the order of time. Raises BadInput: it is damaged."""
        import av
        import av.error

        last_s = -np.inf
        with av.open(str(self.path)) as box:
            stream: Any = box.streams.best("video")
            stream.thread_type = "AUTO"
            try:
                for frame in box.decode(stream):
                    if frame.is_corrupt:
                        raise ValueError
                    time_s = _time_s(frame)
                    if time_s > last_s:
                        last_s = time_s
                        yield time_s * self.time_scale, grey(frame)
            except (av.error.FFmpegError, ValueError) as error:
                raise BadInput(
                    f"{self.path}: the file is damaged after {max(last_s, 0.0):.2f} s: copy it "
                    "from the phone again, or cut off what follows"
                ) from error


def grey(frame: Any) -> Grey:
    """Return a frame's brightness, (height, width) of bytes, without a copy where possible."""
    if re.fullmatch("yuvj?4..p|nv12", frame.format.name):
        plane = frame.planes[0]
        flat = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)
        return flat[:, : plane.width]
    return frame.to_ndarray(format="gray")


def _time_s(part: Any) -> float:
    """Return the time of a packet or a frame, s; NaN if it has none."""
    if part.pts is None or part.time_base is None:
        return float("nan")
    return float(part.pts * part.time_base)
