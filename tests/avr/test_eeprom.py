"""Settings in the EEPROM of the chip: they outlive a power loss.

firmware/test_settings cuts the power at every byte of every save; firmware/test_controller refuses
one in motion.
"""

import pytest
from avr.dialogue import Dialogue, fields

pytestmark = pytest.mark.avr

SAVE_S = 3.0  # well under 100 bytes at 3.4 ms, twice


def opened(board) -> Dialogue:
    talk = Dialogue(board)
    talk.hello()
    return talk


def test_saved_settings_survive_power_loss(start):
    talk = opened(start())
    for _ in range(2):  # into both copies
        for command in ("set angle_ramp 61.5", "set silence 7.25", "trim 3 centre 1420"):
            assert talk.ask(command).startswith("ok:")
        assert talk.ask("save", SAVE_S).startswith("ok:")
    assert talk.board.counts.eeprom_ignored == 0
    again = opened(start(eeprom=talk.board.eeprom))
    before, after = fields(talk.greeting), fields(again.greeting)
    assert after["settings"] == "ok"
    assert int(after["boot"]) == int(before["boot"]) + 1
    listed = [*again.ask_data("set")[0], *again.ask_data("trim")[0]]
    for row in ("set: angle_ramp value=61.5 ", "set: silence value=7.25 ", "trim: #3 centre=1420 "):
        assert any(line.startswith(row) for line in listed), row
