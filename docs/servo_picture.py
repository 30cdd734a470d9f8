"""The picture of why servos cost speed: a joint's rate inside the frames, speed by its ripple."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import serpenoid as sn
from serpenoid.periodic.servo_steady import with_servo
from serpenoid.show.plot import BLUE, GREEN, GREY, ORANGE, RED, figure

ROBOT = sn.Robot(6, 0.0756, 0.076)
GROUND = sn.Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
GAIT = sn.Gait(math.radians(70), math.radians(75), math.tau * 0.5)
DRAWS, FRAMES_S = 48, (0.02, 0.01, 0.005)
SHOWN_S, FROM_S, JOINT = 0.16, 2.0, 2
QUICK = "servo without a rotor"


def draw(path: Path) -> None:
    """Draw the 2005 robot's gait of 70°/75° at 0.5 Hz with servos, quick and heavy, into a file."""
    with figure(9.6, 4.0, 2, path=path) as (_, (left, right)):
        _rates(left)
        _speeds(right)


def _rates(ax: Any) -> None:
    """Draw the rate of one joint over some frames."""
    shown = {"dt_s": 5e-4, "record_every": 1, "duration_s": FROM_S + SHOWN_S, "drive": "servo"}
    for servo, colour, label in (
        (sn.Servo(), RED, QUICK),
        (sn.servo().servo, BLUE, "typical hobby servo"),
    ):
        run = sn.simulate(sn.Scene(ROBOT, GROUND, GAIT, servo=servo, **shown))
        rate = np.diff(run.omega_rad_s, axis=1)[:, JOINT]
        late = run.t_s >= FROM_S
        ax.plot(1e3 * (run.t_s[late] - FROM_S), rate[late], color=colour, label=label, lw=1.3)
    t = np.linspace(FROM_S, FROM_S + SHOWN_S, 200)
    ideal = GAIT.alpha_rad * GAIT.omega_rad_s * np.cos(GAIT.omega_rad_s * t + JOINT * GAIT.beta_rad)
    ax.plot(1e3 * (t - FROM_S), ideal, color=GREY, ls="--", label="gait", lw=1.3)
    ax.set(
        title="Rate of the third joint",
        xlabel="time (ms), frames of 20 ms",
        ylabel="rad/s",
        xticks=np.arange(0, 1e3 * SHOWN_S + 1, 20),
        ylim=(-6.0, 0.2),
    )
    ax.legend(loc="upper right", fontsize=8)


def _speeds(ax: Any) -> None:
    """Draw speed by ripple, for hobby servos drawn at random on three lengths of frames."""
    ideal = sn.steady_gait(ROBOT, GROUND, GAIT, powers=False)
    quick = {"marker": "x", "ms": 8, "mew": 2, "color": RED, "label": QUICK}
    series: list[tuple[list[sn.Servo], dict[str, Any]]] = [
        (
            [replace(servo, frame_s=frame_s) for servo in sn.servo().draws(DRAWS)],
            {"marker": "o", "ms": 4, "color": c, "label": f"frames of {1e3 * frame_s:g} ms"},
        )
        for frame_s, c in zip(FRAMES_S, (ORANGE, GREEN, BLUE), strict=True)
    ]
    for servos, style in [*series, ([sn.Servo()], quick)]:
        states = [with_servo(ideal, servo) for servo in servos]
        share = [state.speed_m_s / ideal.speed_m_s for state in states]
        ax.plot([state.ripple_rad_s for state in states], share, ls="", **style)
    ax.set(
        title="Speed over that of ideal joints",
        xlabel="ripple of the joints' rates, rms (rad/s)",
        ylabel="share",
        xscale="log",
        ylim=(0.5, 1.05),
    )
    ax.legend(loc="lower left", fontsize=8)
