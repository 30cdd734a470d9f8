"""What a film showed, on the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...model.rows import table
from ..screen import screen

if TYPE_CHECKING:
    from ...video.measure_film import FilmMeasurement
    from ...video.result import FilmedRun


def show_film(found: FilmMeasurement) -> None:
    """Print speed, turn, rate, the joints and the remarks."""
    run, out = found.run, screen(highlight=False, soft_wrap=True)
    out.print(_summary(run))
    out.print(table("joints, in degrees", *_joints(found)), soft_wrap=False)
    film, camera = run.film, run.camera
    out.print(
        f"{film['frames']} frames of {film['width_px']} x {film['height_px']} px, "
        f"{film['duration_s']:.2f} s; tags seen in {100 * min(run.tags_seen):.1f} % of the "
        f"frames or more; residuals {run.residual_px:.2f} px, {1e3 * run.residual_m:.2f} mm; "
        f"links of {1e3 * run.link_length_m:.1f} mm give tags of "
        f"{1e3 * camera['tag_side_m']:.1f} mm, printed {1e3 * camera['printed_side_m']:.1f} mm"
    )
    for remark in run.remarks:
        out.print(f"{remark.name}: {remark.text}")


def _summary(run: FilmedRun) -> str:
    hertz, hertz_sigma = run.omega_rad_s / math.tau, run.omega_sigma_rad_s / math.tau
    lines = [
        f"speed      {1e3 * run.speed_m_s:.2f} ± {1e3 * run.speed_sigma_m_s:.2f} mm/s along "
        f"{1e3 * run.path_m:.0f} mm",
        f"direction  {math.degrees(run.direction_rad):+.1f}° ± "
        f"{math.degrees(run.direction_sigma_rad):.1f}° from where the links point",
        f"turn       {math.degrees(run.turn_rad_s):+.3f} ± "
        f"{math.degrees(run.turn_sigma_rad_s):.3f} °/s",
        f"rate       {hertz:.5f} ± {hertz_sigma:.5f} Hz, {run.periods:.2f} periods",
    ]
    if run.time_scale != 1.0:
        lines.append(f"times      those of the file, times {run.time_scale:.5g}: the board's")
    return "\n".join(lines)


def _joints(found: FilmMeasurement) -> tuple[list[str], list[list[str]]]:
    """Return heads and cells of the joints' table, with what was commanded where it is known."""
    gait, cells = found.gait, []
    commanded = ["gain", "late"] if gait else []
    for joint in found.run.joints:
        row = [
            str(joint.joint),
            _pair(joint.amplitude_rad, joint.amplitude_sigma_rad),
            _pair(joint.offset_rad, joint.offset_sigma_rad),
            _pair(joint.phase_rad, joint.phase_sigma_rad),
        ]
        if gait:
            late = joint.phase_rad - (joint.joint - 1) * gait.beta_rad
            late = math.remainder(late, math.tau) if math.isfinite(late) else late
            share = joint.amplitude_rad / gait.alpha_rad if gait.alpha_rad else math.nan
            row += [f"{100 * share:.0f} %", f"{math.degrees(late):+.2f}"]
        cells.append([*row, f"{100 * joint.seen:.0f} %"])
    return ["joint", "amplitude", "centre", "phase", *commanded, "seen"], cells


def _pair(value_rad: float, sigma_rad: float) -> str:
    if math.isnan(value_rad):
        return "not seen"
    return f"{math.degrees(value_rad):.2f} ± {math.degrees(sigma_rad):.2f}"
