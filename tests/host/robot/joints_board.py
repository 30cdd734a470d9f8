"""Virtual boards of another number of joints: the firmware compiled anew, behind a Link."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from serpenoid.robot.wire.virtual import VirtualLink

HERE = Path(__file__).resolve().parent
FIRMWARE = HERE.parents[2] / "firmware"
MOST_READ = 1 << 20


@cache
def library(joints: int, folder: Path) -> ctypes.CDLL:
    """Compile firmware/lib for so many joints and load it."""
    path = folder / f"board-{joints}-joints.so"
    sources = [HERE / "joints_board.cpp", *sorted((FIRMWARE / "lib").glob("*/*.cpp"))]
    folders = [FIRMWARE / "virtual", *sorted((FIRMWARE / "lib").iterdir())]
    flags = ["-std=gnu++11", "-O1", "-shared", "-fPIC", f"-DSERPENOID_JOINTS={joints}"]
    includes = [f"-I{include}" for include in folders]
    subprocess.run(["c++", *flags, *includes, "-o", path, *sources], check=True)
    lib = ctypes.CDLL(str(path))
    lib.board_new.restype = ctypes.c_void_p
    lib.board_read.restype, lib.board_time_s.restype = ctypes.c_size_t, ctypes.c_double
    return lib


class JointsBoard:
    """What VirtualLink needs of serpenoid._core.firmware.Board, with any number of joints."""

    def __init__(self, lib: ctypes.CDLL):
        self._lib, self._board = lib, ctypes.c_void_p(lib.board_new())
        self._room = ctypes.create_string_buffer(MOST_READ)

    def __del__(self) -> None:
        self._lib.board_delete(self._board)

    @property
    def time_s(self) -> float:
        return self._lib.board_time_s(self._board)

    def run(self, seconds: float) -> None:
        self._lib.board_run(self._board, ctypes.c_double(seconds))

    def write(self, data: bytes) -> None:
        self._lib.board_write(self._board, data, ctypes.c_size_t(len(data)))

    def read(self) -> bytes:
        said = self._lib.board_read(self._board, self._room, ctypes.c_size_t(MOST_READ))
        return self._room.raw[:said]


@pytest.fixture(params=[6, 8])
def joints(request: pytest.FixtureRequest) -> int:
    """Return the number of joints, six and then eight."""
    return request.param


@pytest.fixture
def joints_link(
    joints: int, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., VirtualLink]:
    """Put a board of so many joints behind every port a Robot opens; return what opens one."""
    if not shutil.which("c++"):
        if os.environ.get("CI") == "true":
            pytest.fail("no C++ compiler: apt-get install g++")
        pytest.skip("needs a C++ compiler")
    lib = library(joints, tmp_path_factory.getbasetemp())

    def open_link(_port: str | None = None) -> VirtualLink:
        link = VirtualLink(fast=True)
        link.board = JointsBoard(lib)  # type: ignore[assignment]
        return link

    monkeypatch.setattr("serpenoid.robot.robot.open_link", open_link)
    return open_link
