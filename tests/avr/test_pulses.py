"""The firmware's pulses, measured on the pins of a simulated board, against the gait formula."""

import math

import numpy as np
import pytest
from avr.dialogue import Dialogue, telemetry
from avr.truth import Wave, line_errors_us, pulse_errors_us

pytestmark = pytest.mark.avr

ALPHA_DEG, BETA_DEG, OMEGA_RAD_S = 30.0, 80.0, 5.0
RAMP_S = 4.0  # 80 degrees of lag at 60 degrees/s, 5 rad/s at 5 rad/s^2, with a margin
# A pulse is a whole number of microseconds (0.5 us of rounding) ended by an interrupt that can be
# delayed by another one: standard deviation 0.4 to 0.7 us, rare extremes to 8 us.
P99_US, EXTREME_US = 3.0, 10.0


def settled_gait(board, last_number: int = 0) -> Dialogue:
    talk = Dialogue(board, last_number)
    talk.hello()
    assert talk.ask(f"gait {ALPHA_DEG} {BETA_DEG} {OMEGA_RAD_S}").startswith("ok:")
    talk.keep_alive(RAMP_S)
    return talk


def observe(talk: Dialogue, seconds: float):
    """Return the telemetry of the next seconds; the host pings meanwhile."""
    first = len(talk.board.lines)
    talk.keep_alive(seconds)
    return telemetry(talk.board.lines[first:])


def wave_of(
    seen, alpha_deg=ALPHA_DEG, beta_deg=BETA_DEG, omega_rad_s=OMEGA_RAD_S, steering_deg=0.0
):
    """Pin the formula to the phase of the first line; all later frames follow from omega alone."""
    return Wave(
        math.radians(alpha_deg),
        math.radians(beta_deg),
        omega_rad_s,
        int(seen.frame[0]),
        float(seen.phase_rad[0]),
        math.radians(steering_deg),
    )


@pytest.mark.parametrize("name", ["uno", pytest.param("nano", marks=pytest.mark.slow), "mega"])
def test_pulses_and_lines_follow_the_formula_for_ten_seconds(start, name):
    talk = settled_gait(start(name))
    seen = observe(talk, 10.0)
    assert len(seen.frame) >= 495, "telemetry lines are missing"
    errors = pulse_errors_us(talk.board, seen, wave_of(seen))
    assert len(errors) >= 5 * 490, "pulses are missing"
    assert np.percentile(np.abs(errors), 99) <= P99_US
    assert np.max(np.abs(errors)) <= EXTREME_US
    assert abs(np.mean(errors)) <= 1.0  # rounding is unbiased; interrupts only lengthen
    lines = line_errors_us(talk.board, seen)
    assert np.percentile(np.abs(lines), 99) <= P99_US
    assert np.max(np.abs(lines)) <= EXTREME_US
