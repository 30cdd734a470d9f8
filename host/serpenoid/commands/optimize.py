"""The command `serpenoid optimize`: the gait that costs least power at a speed."""

from __future__ import annotations

from typing import Any

import click

from .options import AS_JSON, describe, interruptible, make_robot, robot_options, show_json


@click.command()
@robot_options
@click.option("--speed-m-s", type=float, required=True, help="Wanted speed.")
@click.option("--cost", type=click.Choice(["power", "abs_power", "positive_power"]),
              default="power", show_default=True, help="Mean power to make least.")  # fmt: skip
@AS_JSON
def optimize(as_json: bool, speed_m_s: float, cost: str, **given: Any) -> None:
    """Find the gait that costs least power at a speed."""
    from ..gaits.least_power import least_power_gait
    from ..periodic.steady import steady_gait
    from ..show import report

    robot, ground = make_robot(given)
    with report.busy("searching (up to a minute on dry ground)"):
        best = interruptible(
            lambda: least_power_gait(robot, ground, speed_m_s=speed_m_s, cost=cost)
        )
        s = steady_gait(robot, ground, best.gait)  # the search may leave out the other powers
    if as_json:
        show_json({"gait": describe(best.gait), "cost": cost} | s.to_dict())
    else:
        report.steady(s)
