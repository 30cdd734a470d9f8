"""Films of pushes and crawls to what a session keeps, with their progress and remarks shown."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ...show.screen import say

if TYPE_CHECKING:
    from ...calibration.taking.person.push_prompt import CrawlReader, FilmReader
    from ...calibration.taking.steps import Tracked
    from ...model.gait import Gait
    from ...model.robot import Robot


def film_reader(side_m: float | None = None) -> FilmReader:
    """Return what reads a film of a robot with tags; side_m: of a tag, by its links unless given.

    Needs the extra `video` when it is called, not before.
    """

    def read(path: Path, robot: Robot) -> Tracked:
        from ...calibration.taking.steps import Tracked
        from ...video.pushed import track_pushes
        from ..video import film_progress

        with film_progress(path) as tell:
            found = track_pushes(path, robot.links, robot.link_length_m, side_m, tell)
        for remark in found.remarks:
            say(f"{path.name}: {remark.name}: {remark.text}")
        say(
            f"{path.name}: all lengths ± {100 * found.scale_sigma:.1f} %, kept with its pushes; "
            "the fit takes this, or film_scale_sigma_percent in session.toml where that is larger"
        )
        return Tracked({"scale_sigma": round(found.scale_sigma, 6)}, found.rows)

    return read


def crawl_reader(side_m: float | None = None) -> CrawlReader:
    """Return what reads a film of a crawl; side_m: of a tag, by its links unless given.

    Needs the extra `video` when it is called, not before.
    """

    def read(path: Path, robot: Robot, gait: Gait) -> Tracked:
        from ...calibration.taking.steps import Tracked
        from ...video.measure_film import measure_film
        from ...video.reading import film_cells
        from ..video import film_progress

        with film_progress(path) as tell:
            found = measure_film(
                path, robot.links, robot.link_length_m, side_m, gait, progress=tell
            )
        for remark in found.run.remarks:
            say(f"{path.name}: {remark.name}: {remark.text}")
        cells, samples = film_cells(found)
        return Tracked(cells, samples, "video")

    return read
