"""A measured film: on the terminal, and as a picture of path and joints."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np

from ...video.fitting.chain import joint_angles, link_centres
from ...video.result import FilmMeasurement
from ..plot import BLUE, COLOURS, RED, figure, heading
from ..report import console, show, table


def film_figure(film: FilmMeasurement, path: Path) -> None:
    """Draw a measured film into a file."""
    with figure(9.0, 8.4, rows=2, path=path, height_ratios=[1.7, 1.4]) as (fig, (top, bottom)):
        _picture(top, film)
        _joints(bottom, film)
        heading(fig, f"{film.run.film['name']}: {film.run.in_words()}", 11, "black")


def _picture(ax: Any, film: FilmMeasurement) -> None:
    """Draw the first frame, the middle's path, and the chain at start and end."""
    camera = film.measured.bundle.camera
    states = film.measured.track.states
    ax.imshow(film.watched.ground.picture, cmap="gray", vmin=0, vmax=255)
    ax.plot(*camera.plane_px(states[:, :2]).T, color=BLUE, lw=2, label="middle of the robot")
    for k, style, words in ((0, "o-", "links' middles at the start"), (-1, "o:", "at the end")):
        chain = camera.plane_px(link_centres(states[k], camera.link_m))
        ax.plot(*chain.T, style, color=RED, lw=1.5, ms=3, label=words)
    height_px, width_px = film.watched.ground.picture.shape
    ax.set(title="path over the first frame", xlim=(0, width_px), ylim=(height_px, 0))
    ax.axis("off")
    ax.legend(loc="lower right", frameon=True)


def _joints(ax: Any, film: FilmMeasurement) -> None:
    """Draw each joint's angle as dots, over its sine."""
    track, m = film.measured.track, film.measured.motion
    phi = np.degrees(np.where(film.measured.joint_mask, joint_angles(track.states), np.nan))
    t = track.t_s - track.t_s[0]
    waves = np.sin(m.omega_rad_s * m.t_s[:, None] + m.phase_rad)
    sines = np.degrees(m.offset_rad + m.amplitude_rad * waves)
    for i, (angle, sine, colour) in enumerate(zip(phi.T, sines.T, itertools.cycle(COLOURS)), 1):
        ax.plot(t, angle, ".", ms=2.5, color=colour)
        ax.plot(t, sine, lw=0.9, color=colour, label=f"joint {i}")
    ax.set(title="joints: dots seen, lines the fitted sines", ylabel="angle (°)", xlabel="time (s)")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    ax.set_xlim(0, t[-1])


def show_film(measured: FilmMeasurement) -> None:
    """Print speed, turn, rate, the joints and the remarks."""
    run = measured.run
    show(run)
    table("joints, in degrees", *_cells(measured))
    film, camera = run.film, run.camera
    console.print(
        f"{film['frames']} frames of {film['width_px']} x {film['height_px']} px, "
        f"{film['duration_s']:.2f} s; residuals {run.residual_px:.2f} px; tags of "
        f"{1e3 * camera['tag_side_m']:.1f} mm by the links' length, "
        f"{1e3 * camera['printed_side_m']:.1f} mm as printed",
        soft_wrap=True,
    )
    for remark in run.remarks:
        console.print(f"{remark.name}: {remark.text}", soft_wrap=True)


def _cells(film: FilmMeasurement) -> tuple[list[str], list[list[str]]]:
    """Return heads and cells of the joints' table, with what was commanded where it is known."""
    cells = []
    for joint in film.run.joints:
        values_rad = joint.amplitude_rad, joint.offset_rad, joint.phase_rad
        sigmas_rad = joint.amplitude_sigma_rad, joint.offset_sigma_rad, joint.phase_sigma_rad
        pairs_deg = np.degrees([values_rad, sigmas_rad]).T
        row = [str(joint.joint), *(f"{value:.2f} ± {sigma:.2f}" for value, sigma in pairs_deg)]
        if film.gait:
            row.append(f"{joint.amplitude_rad / max(film.gait.alpha_rad, 1e-9):.0%}")
        cells.append([*row, f"{joint.seen:.0%}"])
    commanded = ["gain"] if film.gait else []
    return ["joint", "amplitude", "centre", "phase", *commanded, "seen"], cells
