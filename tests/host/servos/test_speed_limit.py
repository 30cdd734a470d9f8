"""One decision that a gait is too fast for a servo, and the one sentence that states it."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
import serpenoid as sn
from robots import gait_in_deg
from serpenoid.servos.speed_limit import highest_hz, is_too_fast, too_fast_text
from serpenoid.taking.new_session import default_setup, on_place

HOBBY = sn.servo("hobby")


def test_the_sentence_names_rate_limit_and_frequency() -> None:
    """70 degrees at .8 Hz turn joints at 6.14 rad/s; at 5.37 V 90 % of 6.25 rad/s are 5.62."""
    assert too_fast_text(gait_in_deg(70, 75, math.tau * 0.8), HOBBY) == (
        "Too fast for a typical hobby servo: the joints must turn at 6.1 rad/s; the limit is 5.6 "
        "(90 % of its no-load speed, 6.2). Stay below 0.73 Hz."
    )
    named = too_fast_text(gait_in_deg(70, 75, math.tau), sn.servo("S3003"), "70°/75°, 1 Hz")
    assert named.startswith("70°/75°, 1 Hz is too fast for a typical S3003 servo: ")


@pytest.mark.parametrize("kind", ["hobby", "SG90", "S3003", "MX-64"])
@pytest.mark.parametrize("alpha_deg", [20, 47, 70, 90])
def test_who_heeds_the_sentence_can_run_the_gait(kind: str, alpha_deg: float) -> None:
    servo = sn.servo(kind)
    gait = gait_in_deg(alpha_deg, 75, 60.0)
    told = re.search(r"Stay below ([\d.]+) Hz", too_fast_text(gait, servo))
    assert told
    slower = replace(gait, omega_rad_s=0.995 * math.tau * float(told[1]))
    assert not is_too_fast(slower, servo)
    assert highest_hz(slower, servo) == pytest.approx(highest_hz(gait, servo))
    above = replace(gait, omega_rad_s=1.0001 * math.tau * highest_hz(gait, servo))
    rate, limit = map(float, re.findall(r"([\d.]+) (?:rad/s;|\()", too_fast_text(above, servo)))
    assert rate > limit  # digits enough to tell them apart


def test_servos_that_are_ideal_or_measured_decide_too() -> None:
    gait = gait_in_deg(70, 75, math.tau * 0.8)
    assert not is_too_fast(gait, None)
    assert "for the given servo" in too_fast_text(gait, HOBBY.servo)
    quick = replace(HOBBY, drawn=tuple(HOBBY.servo.at_volts(v) for v in (5.0, 7.0, 7.5)))
    assert not is_too_fast(gait, quick)  # the median of the samples
    gained = replace(gait, joint_gain=(1.0, 1.0, 1.4, 1.0, 1.0))
    assert is_too_fast(gained, quick)


@pytest.mark.parametrize("place", ["treadmill", "floor"])
def test_planned_gaits_are_not_too_fast_at_4_8_volts(place: str) -> None:
    plan = on_place(default_setup("new").plan, place)
    assert plan.gaits
    assert not any(is_too_fast(gait, HOBBY.at_volts(4.8)) for gait in plan.gaits)
