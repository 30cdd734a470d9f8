"""Draws pushes: where the robot was, the law through it, and what is left between them."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...friction.fit import map_estimate
from ...friction.pushes import Pushes
from ...friction.result import FrictionFit
from ...session.session import Session
from ..plot import COLOURS, GREY, fit_heading


def draw_pushes(fig: Figure, axes: Any, session: Session, fit: FrictionFit) -> None:
    """Draw ways over time with the law's line, and residuals; one colour a bend.

    Of a push that is known by its rest alone there is that one place.
    """
    estimate, paths = map_estimate(session), list[Any]()
    for pushes in estimate.posterior.kinds:
        if isinstance(pushes, Pushes):
            laws = pushes.laws(estimate.values)[0]
            parts = zip(session.kept_pushes, pushes.tracks, pushes.linear, laws, strict=True)
            for push, track, linear, law in parts:
                errors = track.residuals(np.concatenate([linear.start, law])[None])[0]
                law_m = track.along_m + errors[: len(track.t_s)] * track.place_sigma_m
                paths.append((push, track.t_s, track.along_m, law_m))
    bends = sorted({round(math.degrees(push.lambda_rad)) for push, *_ in paths})
    for bend, colour in zip(bends, itertools.cycle(COLOURS)):
        name = f"bend {bend}°" if bend else "straight"
        of_bend = (path for path in paths if round(math.degrees(path[0].lambda_rad)) == bend)
        for push, t_s, way_m, law_m in of_bend:
            look = {"color": colour, "ms": 2.5, "mew": 0, "alpha": 0.9, "ls": ""}
            look["marker"] = "o" if push.way == "there" else "s"
            axes[0].plot(t_s, way_m, label=name, **look)
            axes[0].plot(t_s, law_m, color="black", lw=0.8)
            axes[1].plot(t_s, 1000 * (way_m - law_m), **look)
            name = ""
    largest_m = [float(abs(way_m - law_m).max()) for _, _, way_m, law_m in paths]
    limit_mm = max([4.0, *(1100 * largest for largest in largest_m)])
    axes[0].set(title="Positions (squares: back), and the law", ylabel="distance (m)")
    axes[1].set(title="Residuals", ylabel="position less the law (mm)", ylim=(-limit_mm, limit_mm))
    axes[1].axhline(0.0, color=GREY, lw=0.8)
    for ax in axes:
        ax.set(xlabel="time since the first position that counts (s)", xlim=(0, None))
    axes[0].legend(loc="lower right", markerscale=3)
    fit_heading(fig, fit)
