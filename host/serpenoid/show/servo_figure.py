"""The picture of why servos cost speed: a joint's rate inside the frames, speed by its ripple."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..model.drives import Servo
from ..model.gait import Gait
from ..model.ground import Ground
from ..model.robot import Robot
from ..periodic.servo_steady import with_servo
from ..periodic.steady import Steady, steady_gait
from ..servos.catalogue import servo
from ..simulation.scene import Scene
from ..simulation.simulate import simulate
from .plot import BLUE, GREEN, GREY, ORANGE, RED, figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ROBOT = Robot(6, 0.0756, 0.076)
_GROUND = Ground.whole_body(links=6, ct=0.084, cn=1.2, ft0=0.14, fn0=0.27)
_GAIT = Gait(math.radians(70), math.radians(75), math.tau * 0.5)
_DRAWS, _FRAMES_S = 48, (0.02, 0.01, 0.005)
_SHOWN_S, _FROM_S = 0.16, 2.0
_JOINT = 2


def servo_figure(path: Path) -> None:
    """Draw the 2005 robot's gait of 70°/75° at 0.5 Hz with servos, quick and heavy, into a file."""
    ideal = steady_gait(_ROBOT, _GROUND, _GAIT, powers=False)
    with figure(9.6, 4.0, 2, path=path) as (_, (left, right)):
        _rates(left)
        _speeds(right, ideal)


def _rates(ax: Axes) -> None:
    """Draw the rate of one joint over some frames."""
    for one, colour, label in (
        (Servo(), RED, "servo without a rotor"),
        (servo().servo, BLUE, "typical hobby servo"),
    ):
        run = simulate(
            Scene(
                _ROBOT,
                _GROUND,
                _GAIT,
                drive="servo",
                servo=one,
                dt_s=5e-4,
                record_every=1,
                duration_s=_FROM_S + _SHOWN_S,
            )
        )
        rate = np.diff(run.omega_rad_s, axis=1)[:, _JOINT]
        shown = run.t_s >= _FROM_S
        ax.plot(1e3 * (run.t_s[shown] - _FROM_S), rate[shown], color=colour, label=label, lw=1.3)
    t = np.linspace(_FROM_S, _FROM_S + _SHOWN_S, 200)
    phase = _GAIT.omega_rad_s * t + _JOINT * _GAIT.beta_rad
    ideal = _GAIT.alpha_rad * _GAIT.omega_rad_s * np.cos(phase)
    ax.plot(1e3 * (t - _FROM_S), ideal, color=GREY, ls="--", label="gait", lw=1.3)
    ax.set(
        title="Rate of the third joint",
        xlabel="time (ms), frames of 20 ms",
        ylabel="rad/s",
        xticks=np.arange(0, 1e3 * _SHOWN_S + 1, 20),
        ylim=(-6.0, 0.2),
    )
    ax.legend(loc="upper right", fontsize=8)


def _speeds(ax: Axes, ideal: Steady) -> None:
    """Draw speed by ripple, for hobby servos drawn at random on three lengths of frames."""
    for frame_s, colour in zip(_FRAMES_S, (ORANGE, GREEN, BLUE), strict=True):
        found = [with_servo(ideal, replace(one, frame_s=frame_s)) for one in servo().draws(_DRAWS)]
        share = [s.speed_m_s / ideal.speed_m_s for s in found]
        ripple = [s.ripple_rad_s for s in found]
        ax.plot(ripple, share, "o", ms=4, color=colour, label=f"frames of {1e3 * frame_s:g} ms")
    quick = with_servo(ideal, Servo())
    ax.plot(
        quick.ripple_rad_s,
        quick.speed_m_s / ideal.speed_m_s,
        "x",
        ms=8,
        mew=2,
        color=RED,
        label="servo without a rotor",
    )
    ax.set(
        title="Speed over that of ideal joints",
        xlabel="ripple of the joints' rates, rms (rad/s)",
        ylabel="share",
        xscale="log",
        ylim=(0.5, 1.05),
    )
    ax.legend(loc="lower left", fontsize=8)
