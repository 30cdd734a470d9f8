"""A film file: its frames as grey pictures, one after the other, with the file's own times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...model.errors import BadInput
from .extra import need_extra

Grey = NDArray[np.uint8]


@dataclass(frozen=True)
class Film:
    """What the file says of itself; frames() reads it.

    width, height: of the coded picture, px, before any rotation. duration_s, frames_told: as the
    file tells, 0 where it does not. codec: such as h264. rotation_deg: how players turn it.
    """

    path: Path
    width: int
    height: int
    duration_s: float
    frames_told: int
    codec: str

    @staticmethod
    def open(path: Path) -> Film:
        """Read what the file says. Raises BadInput: no film, damaged, or a single picture."""
        av = _library()
        try:
            with av.open(str(path)) as box:
                stream = _stream(box, path)
                size = stream.codec_context.width, stream.codec_context.height
                duration = float(box.duration or 0) / 1e6
                film = Film(
                    path, *size, duration, int(stream.frames or 0), stream.codec_context.name
                )
        except (av.FFmpegError, ValueError) as error:
            raise BadInput(_unreadable(path, error)) from error
        if min(film.width, film.height) < 64:
            raise BadInput(
                f"{path}: the picture is {film.width} x {film.height} px; no robot can "
                "be measured in that: film at 1080p"
            )
        return film

    def frames(self, damage: list[str]) -> Iterator[tuple[float, Grey, Any]]:
        """Give time (s), grey picture and the frame itself, in the order of time.

        A damaged end or middle is told in `damage`, and what can be read is given: a picture
        that is drawn on a broken one is left out, until the next that stands alone.
        """
        av = _library()
        last = -np.inf
        broken = False
        with av.open(str(self.path)) as box:
            stream = _stream(box, self.path)
            stream.thread_type = "AUTO"
            packets = box.demux(stream)
            while True:
                try:
                    packet = next(packets)
                    decoded = packet.decode()
                except StopIteration:
                    return
                except av.FFmpegError as error:
                    damage.append(f"{type(error).__name__} after {max(last, 0.0):.2f} s")
                    broken = True
                    if len(damage) > 200 or isinstance(error, av.EOFError):
                        return
                    continue
                for frame in decoded:
                    if frame.pts is None or frame.time_base is None:
                        damage.append(f"a frame without time after {max(last, 0.0):.2f} s")
                        continue
                    time_s = float(frame.pts * frame.time_base)
                    if time_s <= last:
                        damage.append(f"time runs back at {time_s:.2f} s")
                        continue
                    last = time_s
                    broken = frame.is_corrupt or (broken and not frame.key_frame)
                    if frame.is_corrupt:
                        damage.append(f"a broken picture at {time_s:.2f} s")
                    if broken:
                        continue
                    yield time_s, grey(frame), frame


def grey(frame: Any) -> Grey:
    """Return a frame's brightness, (height, width) of bytes, without a copy where possible."""
    if frame.format.name in ("yuv420p", "yuvj420p", "nv12", "yuv422p", "yuvj422p", "yuv444p"):
        plane = frame.planes[0]
        flat = np.frombuffer(plane, np.uint8).reshape(plane.height, plane.line_size)
        return flat[:, : plane.width]
    return frame.to_ndarray(format="gray")


def _stream(box: Any, path: Path) -> Any:
    if not box.streams.video:
        raise BadInput(f"{path}: holds no pictures (sound only?); name the film itself")
    return box.streams.video[0]


def _library() -> Any:
    need_extra()
    import av

    return av


def _unreadable(path: Path, error: Exception) -> str:
    if not path.exists():
        return f"{path}: there is no such file"
    if path.is_dir():
        return f"{path}: a folder; name the film in it"
    words = str(getattr(error, "strerror", None) or error)
    return (
        f"{path}: cannot be read as a film ({words}); copy it from the phone again, as MP4 or MOV"
    )
