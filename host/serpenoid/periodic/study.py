"""Sweeps larger than memory: a folder of chunks, which can be interrupted and gone on with."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..model.checks import check_whole
from ..model.errors import BadInput
from ..model.files import read_arrays, read_json, whole_file, write_text
from ..model.ground import Ground
from ..model.long_calls import Progress, threads_to_use
from ..model.robot import Robot
from ..model.rows import Result
from ..model.vectors import Array
from .cluster import Stretch, solved, stretch_length
from .grid import AXES, FIELDS, Grid, stretches

FORMAT = "serpenoid study 2"
HEAD = "study.json"


@dataclass(frozen=True)
class Study(Result):
    """Hold a sweep whose figures lie in a folder; iterate over it for one chunk after another.

    Each chunk is a dict of arrays: robot, ground (S,), indices into grid.robots and grid.grounds;
    alpha_rad, beta_rad (S,); omega_rad_s (W,); and what Sweep has, each (S, W).

    Attributes
    ----------
    folder
        Where the chunks are.
    grid
        Robots, grounds, gaits and accuracy.
    length
        Number of shapes in a chunk.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> rates = [4.0, 5.0]
    >>> study = sn.sweep_study(
    ...     robot, ground, out="study", alpha_rad=[0.4], beta_rad=[1.4], omega_rad_s=rates
    ... )
    >>> study.folder.name
    'study'
    """

    folder: Path
    grid: Grid
    length: int

    @property
    def chunks(self) -> tuple[Stretch, ...]:
        """Return the shapes of each chunk: first, and last plus one."""
        return tuple(stretches(self.grid.shapes, self.length))

    def path(self, chunk: Stretch) -> Path:
        """Return the file of a chunk; it is there when the chunk is done, and whole."""
        return self.folder / f"chunk-{chunk[0]:012d}.npz"

    @property
    def missing(self) -> tuple[Stretch, ...]:
        """Return the chunks that are still to be solved."""
        return tuple(chunk for chunk in self.chunks if not self.path(chunk).exists())

    def __iter__(self) -> Iterator[dict[str, NDArray[Any]]]:
        """Yield the chunks that are done, in order. Raises BadInput: one is damaged."""
        for chunk in self.chunks:
            if self.path(chunk).exists():
                yield self.read(chunk)

    @property
    def head(self) -> dict[str, Any]:
        """Return what the head of the folder says: the grid, and how it is cut into chunks."""
        return {"format": FORMAT, **asdict(self.grid), "shapes": self.length}

    @cached_property
    def _hash(self) -> NDArray[np.uint8]:
        """Return the SHA-256 of the head: a chunk that carries another is of another study."""
        text = json.dumps(self.head, sort_keys=True)
        return np.frombuffer(hashlib.sha256(text.encode()).digest(), np.uint8)

    def read(self, chunk: Stretch) -> dict[str, NDArray[Any]]:
        """Return a chunk that is done. Raises BadInput: damaged, or of another place or study."""
        path, rows = self.path(chunk), chunk[1] - chunk[0]
        most = 8 * rows * (len(FIELDS) * len(self.grid.omega_rad_s) + 4)
        cure = "delete it and ask for the study again: it is solved anew"
        try:
            chunk_arrays = read_arrays(path, most + 8 * len(self.grid.omega_rad_s) + 10_000)
        except BadInput as error:
            raise BadInput(f"{error}; {cure}") from None
        whose, where = chunk_arrays.pop("study_sha256", ()), chunk_arrays.pop("first_and_last", ())
        if not (np.array_equal(whose, self._hash) and np.array_equal(where, chunk)):
            raise BadInput(f"{path} is of another study, or another chunk of this one; {cure}")
        if any(len(chunk_arrays.get(name, ())) != rows for name in ("robot", *FIELDS)):
            raise BadInput(f"{path} is damaged (it has not {rows} shapes); {cure}")
        return chunk_arrays

    def write(self, chunk: Stretch, table: Array) -> None:
        """Write the file of a chunk: whole, or not at all."""
        first, last = chunk
        robot, ground, alpha, beta = np.unravel_index(np.arange(first, last), self.grid.size)
        with whole_file(self.path(chunk)) as part, part.open("wb") as file:
            np.savez(
                file,
                allow_pickle=False,
                study_sha256=self._hash,
                first_and_last=np.array(chunk),
                robot=robot,
                ground=ground,
                alpha_rad=np.array(self.grid.alpha_rad)[alpha],
                beta_rad=np.array(self.grid.beta_rad)[beta],
                omega_rad_s=np.array(self.grid.omega_rad_s),
                **self.grid.named(table, first),
            )


def sweep_study(
    robot: Robot | Sequence[Robot],
    ground: Ground | Sequence[Ground],
    *,
    out: str | os.PathLike[str],
    alpha_rad: ArrayLike,
    beta_rad: ArrayLike,
    omega_rad_s: ArrayLike,
    rtol: float = 1e-6,
    powers: bool = True,
    threads: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Study:
    """Solve a grid of any size, as sweep does, into a folder of chunks.

    Memory holds a few chunks at a time. Chunks of the same study that are already there are kept:
    after an interruption, call it again to continue.

    Parameters
    ----------
    robot, ground, alpha_rad, beta_rad, omega_rad_s, rtol, powers, threads, scheduler, progress
        As in `sweep`: alpha_rad and beta_rad in rad, omega_rad_s in rad/s.
    out
        The folder.

    Returns
    -------
    Study
        The folder's chunks, read when they are used.

    Raises
    ------
    BadInput
        If the folder holds something else.
    ClusterFailed
        If the cluster cannot be reached or has other versions.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> rates = [4.0, 5.0]
    >>> study = sn.sweep_study(
    ...     robot, ground, out="study", alpha_rad=[0.4], beta_rad=[1.4], omega_rad_s=rates
    ... )
    >>> study.grid.gaits
    2
    """
    grid = Grid.of(robot, ground, (alpha_rad, beta_rad, omega_rad_s), rtol, powers)
    count = threads_to_use(threads)
    study = _prepared(Path(out), grid)
    missing, rates = study.missing, len(grid.omega_rad_s)
    if progress is not None:
        progress(grid.gaits - rates * sum(last - first for first, last in missing))
    if missing:
        with contextlib.closing(solved(grid, count, scheduler, progress, missing)) as tables:
            for chunk, table in tables:
                study.write(chunk, table)
    return study


def load_study(folder: str | os.PathLike[str]) -> Study:
    """Return the study that a folder holds, complete or not.

    Parameters
    ----------
    folder
        As `sweep_study` wrote it.

    Returns
    -------
    Study
        The folder's chunks, read when they are used.

    Raises
    ------
    BadInput
        If the folder holds no study.

    Examples
    --------
    >>> robot = sn.Robot(links=6, link_mass_kg=1.0, link_length_m=0.12)
    >>> ground = sn.Ground(ct=0.1, cn=10.0)
    >>> rates = [4.0, 5.0]
    >>> study = sn.sweep_study(
    ...     robot, ground, out="study", alpha_rad=[0.4], beta_rad=[1.4], omega_rad_s=rates
    ... )
    >>> sn.load_study("study").grid.gaits
    2
    """
    path = Path(folder) / HEAD
    if not path.exists():
        raise BadInput(f"{folder} holds no study (no {HEAD}); sweep_study writes one")
    head = read_json(path)
    try:
        if head["format"] != FORMAT:
            raise BadInput(
                f"{path} is of format {head['format']!r}; this version reads {FORMAT!r}: solve it "
                "anew into another folder"
            )
        grid = Grid.of(
            [Robot(**robot) for robot in head["robots"]],
            [Ground(**ground) for ground in head["grounds"]],
            [head[name] for name in AXES],
            head["rtol"],
            head["powers"],
        )
        return Study(Path(folder), grid, check_whole("shapes", head["shapes"], 1, grid.shapes))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInput(f"{path} is no head of a study ({error}); sweep_study writes one") from None


def _prepared(folder: Path, grid: Grid) -> Study:
    """Return a folder's study, begun or gone on with."""
    if (folder / HEAD).exists():
        there = load_study(folder)
        if there.grid != grid:
            raise BadInput(
                f"{folder} holds another study, of {there.grid.gaits} gaits: name another folder, "
                "or ask for the very same grid to go on with it"
            )
        return there
    folder.mkdir(parents=True, exist_ok=True)
    if next(folder.iterdir(), None) is not None:
        raise BadInput(f"{folder} is not empty and holds no study; name another folder")
    study = Study(folder, grid, min(stretch_length(grid), grid.shapes))
    write_text(folder / HEAD, json.dumps(study.head) + "\n")
    return study
