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

MOST_BYTES = 1 << 40  # of a film
CAPTURE_TAG = "capture.fps"  # ends the name of the tag in which Android phones say it


@dataclass(frozen=True)
class Film:
    """What the file says of itself; frames() reads it.

    width, height: of the coded picture, px, before any rotation. duration_s: in real time, 0 where
    the file does not tell. codec: such as h264. stream: which of the file's picture streams is the
    film. capture: the camera's rate and that of the file, None where nothing tells the former.
    """

    path: Path
    width: int
    height: int
    duration_s: float
    codec: str
    stream: int = 0
    capture: CaptureRate | None = None

    @property
    def time_scale(self) -> float:
        """Return what the file's times are multiplied with to be real ones."""
        return 1.0 if self.capture is None else self.capture.time_scale

    @staticmethod
    def open(path: Path, capture_fps: float | None = None) -> Film:
        """Read what the file says. Raises BadInput: no film, or damaged.

        capture_fps: pictures a second that the camera took, where somebody says so; else what the
        file's tag says.
        """
        need_extra()
        import av
        import av.error

        check_file(path, MOST_BYTES)
        try:
            with av.open(str(path)) as box:
                number = _moving_stream(box)
                coding = [stream.codec_context for stream in box.streams.video][number : number + 1]
                duration_s = float(box.duration or 0) / 1e6
                tags = {**box.metadata, **(box.streams.video[number].metadata if coding else {})}
        except (av.error.FFmpegError, ValueError) as error:
            words = str(getattr(error, "strerror", None) or error)
            raise BadInput(
                f"{path}: cannot be read as a film ({words}); copy it from the phone again, as MP4 "
                "or MOV"
            ) from error
        if not coding:
            raise BadInput(f"{path}: holds no pictures (sound only?); name the film itself")
        if coding[0] is None:
            raise BadInput(
                f"{path}: the pictures' coding is unknown or damaged; film as H.264 or HEVC, and "
                "copy it from the phone again"
            )
        size = coding[0].width, coding[0].height
        film = Film(path, *size, duration_s, coding[0].name, number)
        if min(film.width, film.height) < 64:
            raise BadInput(
                f"{path}: the picture is {film.width} x {film.height} px; no robot can "
                "be measured in that: film at 1080p"
            )
        return film._in_real_time(capture_fps, tags)

    def _in_real_time(self, capture_fps: float | None, tags: dict[str, str]) -> Film:
        """Return the film with its capture rate, where a person or a tag tells it."""
        tagged = {
            f"the tag {name}": float(text)
            for name, text in tags.items()
            if name.endswith(CAPTURE_TAG) and re.fullmatch(r"[\d.]+", text)
        }
        rates = tagged if capture_fps is None else {OPTION: capture_fps}
        if not rates:
            return self
        source, taken_hz = next(iter(rates.items()))
        if capture_fps is not None and tagged:
            others = [f"{name} says {hertz:g}" for name, hertz in tagged.items()]
            source += f" ({', '.join(others)}, and does not count)"
        capture = capture_rate(self._picture_times(), taken_hz, source)
        duration_s = self.duration_s * capture.time_scale
        return replace(self, duration_s=duration_s, capture=capture)

    def _picture_times(self) -> list[float]:
        """Return the pictures' times as the file has them, s, without decoding any."""
        import av

        with av.open(str(self.path)) as box:
            packets = box.demux(box.streams.video[self.stream])
            return [time_s for p in packets if (time_s := _time_s(p, np.nan)) == time_s]

    def frames(self, damage: list[str]) -> Iterator[tuple[float, Grey]]:
        """Give time (s) and grey picture, in the order of time.

        A film ends at its first picture that cannot be read; `damage` then gets the words for it.
        """
        import av
        import av.error

        last_s = -np.inf
        with av.open(str(self.path)) as box:
            stream: Any = box.streams.video[self.stream]
            stream.thread_type = "AUTO"
            try:
                for frame in box.decode(stream):
                    if frame.is_corrupt:
                        raise ValueError
                    time_s = _time_s(frame, np.nan)
                    if time_s > last_s:
                        last_s = time_s
                        yield time_s * self.time_scale, grey(frame)
            except (av.error.FFmpegError, ValueError):
                damage.append(
                    f"The file is damaged after {max(last_s, 0.0):.2f} s: copy it from the phone "
                    "again"
                )


def _moving_stream(box: Any) -> int:
    """Return which of a file's picture streams is the first with two pictures or more; 0 if none.

    A cover, or a preview, is a stream of one picture.
    """
    streams = box.streams.video
    if len(streams) < 2:
        return 0
    pictures = dict.fromkeys((stream.index for stream in streams), 0)
    for packet in box.demux(*streams):
        pictures[packet.stream.index] += packet.size > 0
        if all(count > 1 for count in pictures.values()):
            break
    return next((k for k, stream in enumerate(streams) if pictures[stream.index] > 1), 0)


def grey(frame: Any) -> Grey:
    """Return a frame's brightness, (height, width) of bytes, without a copy where possible."""
    if frame.format.name in ("yuv420p", "yuvj420p", "nv12", "yuv422p", "yuvj422p", "yuv444p"):
        plane = frame.planes[0]
        flat = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)
        return flat[:, : plane.width]
    return frame.to_ndarray(format="gray")


def _time_s(part: Any, unknown: float) -> float:
    """Return the time of a packet or a frame, s; `unknown` if it has none."""
    if part is None or part.pts is None or part.time_base is None:
        return unknown
    return float(part.pts * part.time_base)
