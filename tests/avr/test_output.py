"""What the board sends: telemetry is dropped and counted, never waited for."""

import numpy as np
import pytest
from avr.dialogue import Dialogue, telemetry
from avr.truth import line_errors_us

pytestmark = pytest.mark.avr

# A pulse is a whole number of microseconds (0.5 us of rounding) ended by an interrupt that can be
# delayed by another one: standard deviation 0.4 to 0.7 us, rare extremes to 8 us.
USUAL_US, EXTREME_US = 3.0, 10.0


def test_a_flood_costs_lines_but_no_motion(start):
    """Two seconds of damaged lines without a pause: each asks for an answer longer than itself."""
    talk = Dialogue(start())
    talk.hello()
    for command in ("set silence 10", "gait 30 80 5"):
        assert talk.ask(command).startswith("ok:")
    board = talk.board
    board.run(4.0)
    before = talk.counters()
    first = len(board.lines)
    damaged = b"#1 ping *0000\n"
    board.send(damaged * int(2.0 * board.baud / 10 / len(damaged)))
    board.send(b"\n", 2.1)  # ends a line whose end was lost
    board.run(2.2)
    board.run_until("t:", 0.1)
    seen = telemetry(board.lines[first:])
    after = talk.counters()
    missing = seen.frame[-1] - seen.frame[0] + 1 - len(seen.frame)
    assert missing <= after["dropped"] - before["dropped"] <= missing + 2
    assert missing <= 0.1 * len(seen.frame), "answers keep clear of the next frame"
    assert after["rxfull"] > before["rxfull"], "lost input must be counted too"
    assert after["overruns"] == before["overruns"] == 0
    # A receive interrupt every 40 us delays an edge in eight, by no more than it lasts.
    errors = np.abs(line_errors_us(board, seen))
    assert np.percentile(errors, 80) <= USUAL_US
    assert np.max(errors) <= EXTREME_US
