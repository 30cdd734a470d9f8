"""The step in which a robot is bent and the protractor laid on, at the treadmill and on a floor."""

from __future__ import annotations

from dataclasses import replace

from ..model.bends import balanced_signs, joint_multiples
from ..session.settings import Setup
from ..session.station import BendCheck
from .steps import Step

NEAR_DEG = 2.5  # off a planned bend: what the protractor then shows raises no doubt


def bend_step(key: str, setup: Setup, bend_deg: float, then: str) -> Step:
    """Return the step to a bend of the plan; then: what is said after how the joints stand."""
    bend, between_deg = setup.plan.bend, 180.0 - 2 * bend_deg
    near = between_deg - 2 * NEAR_DEG, between_deg + 2 * NEAR_DEG
    (shown,) = BendCheck.asked("between_links_deg")
    return Step(
        key,
        "bend",
        f"Bend {bend_deg:g} deg, {bend_in_words(bend, bend_deg, setup.robot.links)} {then}",
        (replace(shown, likely=near),),
        bend_deg,
        bend=bend,
        cells={"lambda_deg": bend_deg, "bend": bend},
    )


def bend_in_words(bend: str, bend_deg: float, links: int) -> str:
    """Return what the joints of a bent robot do, and what a protractor shows there."""
    at_ends = f"A protractor between the last two links at either end shows {180 - 2 * bend_deg:g}"
    if bend == "zigzag":
        return (
            f"zigzag: every joint at {2 * bend_deg:g} deg, left and right in turn. {at_ends} "
            "deg, as at every joint. Guide the robot: left alone it turns."
        )
    multiples = joint_multiples(balanced_signs(links))
    joints = ", ".join(f"{m * bend_deg:+g}" if m else "0" for m in multiples)
    inner = sorted({abs(m) for m in multiples} - {2}, reverse=True)
    there = {1: f"{180 - bend_deg:g} at a joint of {bend_deg:g}", 0: "180 at a joint of 0"}
    rest = "".join(f", {there[m]}" for m in inner)
    return f"balanced: joints from the tail at {joints} deg. {at_ends} deg{rest}."
