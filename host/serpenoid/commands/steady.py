"""The command `serpenoid steady`: the periodic state of one gait."""

from __future__ import annotations

from typing import Any

import click

from ..model.words import FORMULATIONS
from .options import (
    AS_JSON,
    describe,
    gait_options,
    interruptible,
    make_gait,
    make_robot,
    robot_options,
    show_json,
)


@click.command()
@robot_options
@gait_options
@click.option("--rtol", type=float, default=1e-6, show_default=True, help="Relative accuracy.")
@click.option(
    "--formulation",
    type=click.Choice(FORMULATIONS),
    default="explicit",
    show_default=True,
    help="Exact model, or the paper's springs.",
)
@click.option("--stiffness-n-m", type=float, default=1000.0, show_default=True, help="Implicit: k.")
@click.option("--damping-n-s-m", type=float, default=1.0, show_default=True, help="Implicit: c.")
@AS_JSON
def steady(
    as_json: bool,
    rtol: float,
    formulation: str,
    stiffness_n_m: float,
    damping_n_s_m: float,
    **given: Any,
) -> None:
    """Find the periodic state of one gait: speed, powers, settling time, margins."""
    from ..gaits.margins import gait_margins
    from ..periodic.steady import steady_gait
    from ..show import report
    from ..show.gaits import gait_report

    robot, ground = make_robot(given)
    gait = make_gait(given)
    if formulation == "implicit":
        from ..simulation.steady_springs import steady_springs

        soft = steady_springs(
            robot,
            ground,
            gait,
            joint_stiffness_n_m=stiffness_n_m,
            joint_damping_n_s_m=damping_n_s_m,
            rtol=rtol,
        )
        as_dict = {"gait": describe(gait)} | soft.to_dict()
        return show_json(as_dict) if as_json else report.steady_springs(soft)
    s = interruptible(lambda: steady_gait(robot, ground, gait, rtol=rtol))
    margins = interruptible(lambda: gait_margins(robot, ground, gait))
    if as_json:
        return show_json({"gait": describe(gait)} | s.to_dict() | {"margins": margins.to_dict()})
    report.steady(s)
    return gait_report.margins(margins)
